#include <takt/component.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt {
namespace {

using testing::HasSubstr;

struct Everything : Component {
  Property<bool> enabled{*this, "enabled", true};
  Property<std::int32_t> count{*this, "count", 3, {.min = 1, .max = 10, .text = "How many."}};
  Property<std::int64_t> wide{*this, "wide", 0};
  Property<double> gain{*this, "gain", 1.5, {.unit = "1/s", .min = 0.0}};
  Property<double> free{*this, "free", 0.0};
  Property<float> narrow{*this, "narrow", 0.0f, {.max = 1e30f}};
  Property<std::string> label{*this, "label", "none"};
  void run(const Cycle&) noexcept override {}
};

std::string reason(PropertyBase& property, std::string_view text) {
  const auto result = property.assign(text);
  return result ? "" : to_text(result.problems());
}

TEST(Property, IsListedInTheOrderOfDeclaration) {
  Everything component;
  std::string names;
  for (const PropertyBase* property : component.properties()) names += property->name() + " ";
  EXPECT_EQ(names, "enabled count wide gain free narrow label ");
}

TEST(Property, HasItsDefaultUntilItIsSet) {
  const Everything component;
  EXPECT_TRUE(component.enabled);
  EXPECT_EQ(component.count, 3);
  EXPECT_EQ(component.gain, 1.5);
  EXPECT_EQ(component.label.value(), "none");
}

TEST(Property, SaysOfItselfWhatADescriptionNeeds) {
  const Everything component;
  EXPECT_STREQ(to_text(component.enabled.type()), "bool");
  EXPECT_STREQ(to_text(component.count.type()), "integer");
  EXPECT_STREQ(to_text(component.gain.type()), "double");
  EXPECT_STREQ(to_text(component.narrow.type()), "double");
  EXPECT_STREQ(to_text(component.label.type()), "string");
  EXPECT_EQ(component.count.range_text(), "1 to 10");
  EXPECT_EQ(component.gain.range_text(), "at least 0");
  EXPECT_EQ(component.narrow.range_text(), "at most 1e+30");
  EXPECT_EQ(component.free.range_text(), "");
  EXPECT_EQ(component.gain.unit(), "1/s");
  EXPECT_EQ(component.count.text(), "How many.");
  EXPECT_EQ(component.enabled.value_text(), "true");
  EXPECT_EQ(component.gain.value_text(), "1.5");
}

TEST(Property, TakesWhatItsTypeTakes) {
  Everything component;
  EXPECT_EQ(reason(component.enabled, "0"), "");
  EXPECT_EQ(reason(component.count, "+10"), "");
  EXPECT_EQ(reason(component.wide, "-9223372036854775808"), "");
  EXPECT_EQ(reason(component.gain, "2.5e3"), "");
  EXPECT_EQ(reason(component.label, ""), "");
  EXPECT_FALSE(component.enabled);
  EXPECT_EQ(component.count, 10);
  EXPECT_EQ(component.wide, INT64_MIN);
  EXPECT_EQ(component.gain, 2500);
  EXPECT_EQ(component.label.value(), "");
}

TEST(Property, ReadsBackWhatItWrites) {
  Everything component;
  for (const double value : {0.1, 1e-300, 123456789.123456789, 1e300}) {
    ASSERT_TRUE(component.gain.assign(detail::number_text(value)).ok());
    EXPECT_EQ(component.gain, value);
  }
}

TEST(Property, RefusesByNameAndKeepsItsValue) {
  Everything component;
  EXPECT_EQ(reason(component.count, "11"),
            "error: property 'count' cannot be '11'; it takes a whole number, 1 to 10");
  EXPECT_EQ(reason(component.gain, "-0.1"),
            "error: property 'gain' cannot be '-0.1'; it takes a number, at least 0, in 1/s");
  EXPECT_EQ(reason(component.enabled, "yes"),
            "error: property 'enabled' cannot be 'yes'; it takes true or false");
  EXPECT_EQ(component.count, 3);
  EXPECT_EQ(component.gain, 1.5);
  EXPECT_TRUE(component.enabled);
}

TEST(Property, RefusesWhatIsNoNumber) {
  Everything component;
  for (const char* text :
       {"", " 1", "1 ", "1,5", "nan", "-nan", "inf", "0x10", "1e999", "++1", "+-1", "one"}) {
    EXPECT_THAT(reason(component.free, text), HasSubstr("'free'")) << text;
    EXPECT_THAT(reason(component.count, text), HasSubstr("'count'")) << text;
  }
  EXPECT_THAT(reason(component.wide, "1.5"), HasSubstr("a whole number"));
}

TEST(Property, RefusesWhatItsTypeCannotHold) {
  Everything component;
  EXPECT_THAT(reason(component.wide, "9223372036854775808"), HasSubstr("'wide'"));
  EXPECT_THAT(reason(component.count, "4294967297"), HasSubstr("'count'"));  // 1 if it were cut to 32 bits
  EXPECT_THAT(reason(component.narrow, "-1e39"), HasSubstr("'narrow'"));     // below no bound, but no float
  EXPECT_EQ(component.narrow, 0.0f);
}

TEST(Property, HasBoundsThatBelongToIt) {
  Everything component;
  EXPECT_EQ(reason(component.count, "1"), "");
  EXPECT_EQ(reason(component.count, "10"), "");
  EXPECT_NE(reason(component.count, "0"), "");
  EXPECT_EQ(reason(component.gain, "0"), "");
}

TEST(Property, OfTextTakesTheWordsOfItsChoices) {
  Everything component;
  Property<std::string> mode{component, "mode", "slow", {.choices = {"slow", "fast", "off"}}};
  EXPECT_EQ(mode.range_text(), "slow, fast or off");
  EXPECT_TRUE(mode.assign("fast"));
  const auto refused = mode.assign("Fast");
  ASSERT_FALSE(refused);
  EXPECT_EQ(in_words(refused.problems()), "property 'mode' cannot be 'Fast'; it takes text, slow, fast or off");
  EXPECT_EQ(mode.value(), "fast");
}

TEST(Property, TakesARangeThatOnlyTheModuleKnows) {
  Everything component;
  Property<double> cutoff{component, "cutoff", 10, {.unit = "Hz", .min = 0, .max = 1000}};
  EXPECT_TRUE(cutoff.narrow(1, 450, "at a period of 1 ms"));
  const auto refused = cutoff.assign("500");
  ASSERT_FALSE(refused);
  EXPECT_EQ(in_words(refused.problems()),
            "property 'cutoff' cannot be '500'; it takes a number, 1 to 450 at a period of 1 ms, in Hz");
  EXPECT_TRUE(cutoff.narrow({}, 5000, "at a period of 100 us"));  // never wider than it was declared
  EXPECT_FALSE(cutoff.assign("451"));
  EXPECT_FALSE(cutoff.narrow({}, 5, "at a period of 90 ms"));  // and its value has to be within
}

}  // namespace
}  // namespace takt
