#include <cstdint>

#include <takt/module.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace irp_property_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

irp::Property one(const char* text) { return irp::Property(irp::Property::Values{{"value", text}}); }

TEST(IrpProperty, ReturnsTheFallbackValueIfTheDescriptorDoesNotSetIt) {
  const irp::Property property;
  EXPECT_FALSE(property.contains("value"));
  EXPECT_EQ(property.get("value", 5), 5);
  EXPECT_EQ(property.get("value", 0.5), 0.5);
  EXPECT_EQ(property.get("value", true), true);
  EXPECT_EQ(property.get("value", std::string("none")), "none");
  EXPECT_EQ(property.get("value", "none"), "none");
  EXPECT_EQ(property.get("value", 50, 0, 10), 50) << "the fallback is not checked";
}

TEST(IrpProperty, ThrowsIfItHasNeitherAValueNorAFallback) {
  EXPECT_THAT([] { irp::Property().get("speed"); }, ThrowsMessage<std::out_of_range>(HasSubstr("'speed'")));
}

TEST(IrpProperty, ConvertsToTheTypeOfTheFallback) {
  EXPECT_EQ(one("7").get("value"), "7");
  EXPECT_EQ(one("7").get("value", 5), 7);
  EXPECT_EQ(one("+7").get("value", 5), 7);
  EXPECT_EQ(one("-7").get("value", 5LL), -7);
  EXPECT_EQ(one("18446744073709551615").get("value", std::uint64_t{0}), UINT64_MAX);
  EXPECT_EQ(one("2.5e-3").get("value", 0.0), 2.5e-3);
  EXPECT_EQ(one("true").get("value", false), true);
  EXPECT_EQ(one("0").get("value", true), false);
  EXPECT_EQ(one("two words").get("value", ""), "two words");
  EXPECT_EQ(one("").get("value", "none"), "");
}

TEST(IrpProperty, KeepsTheOrderOfTheDescriptor) {
  const irp::Property property(irp::Property::Values{{"b", "1"}, {"a", "2"}});
  EXPECT_EQ(property.values().at(0).first, "b");
  EXPECT_EQ(property.get("a", 0), 2);
}

template <class T>
void expect_rejected(const char* text, T fallback, const char* takes) {
  EXPECT_THAT([&] { one(text).get("value", fallback); },
              ThrowsMessage<std::invalid_argument>(
                  AllOf(HasSubstr("'value'"), HasSubstr("'" + std::string(text) + "'"), HasSubstr(takes))))
      << text;
}

TEST(IrpProperty, RejectsInvalidTextAndStatesWhatItAccepts) {
  for (const char* text : {"", " ", "five", "5 ", " 5", "+", "+-5", "++5", "1.5", "0x10", "1e3", "5;"}) {
    expect_rejected(text, 5, "a whole number");
  }
  for (const char* text : {"", " 1", "1,5", "nan", "inf", "-inf", "0x1p3", "1e999", "1.5V"}) {
    expect_rejected(text, 1.0, "a number");
  }
  for (const char* text : {"", "yes", "True", "2"}) expect_rejected(text, false, "true or false");
}

TEST(IrpProperty, StatesTheRangeWhenANumberDoesNotFitItsType) {
  expect_rejected("2147483648", 5, "-2147483648 to 2147483647");
  expect_rejected("-1", 5u, "0 to 4294967295");
  expect_rejected("128", std::int8_t{0}, "-128 to 127");
  expect_rejected("9223372036854775808", 5LL, "a whole number");
  expect_rejected("1e39", 1.0f, "a number");
}

TEST(IrpProperty, AcceptsOnlyValuesWithinItsBounds) {
  EXPECT_EQ(one("1").get("value", 5, 1, 10), 1);
  EXPECT_EQ(one("10").get("value", 5, 1, 10), 10);
  EXPECT_EQ(one("0.5").get("value", 1.0, 0.5, 2), 0.5);
  EXPECT_THAT([] { one("11").get("value", 5, 1, 10); },
              ThrowsMessage<std::invalid_argument>(AllOf(HasSubstr("'11'"), HasSubstr("1 to 10"))));
  EXPECT_THAT([] { one("0.4").get("value", 1.0, 0.5, 2); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("0.5 to 2")));
}

}  // namespace
}  // namespace irp_property_test
