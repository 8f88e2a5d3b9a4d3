#include <takt/property.h>
#include <takt/component.hpp>
#include <takt/process.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::property_test {
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

TEST(Property, IsListedInDeclarationOrder) {
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

TEST(Property, DescribesItsTypeRangeAndUnitAsText) {
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

TEST(Property, AcceptsEveryValueOfItsType) {
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

TEST(Property, KeepsANumberExactlyWhenSetFromItsText) {
  Everything component;
  for (const double value : {0.1, 1e-300, 123456789.123456789, 1e300}) {
    ASSERT_TRUE(component.gain.assign(detail::number_text(value)).ok());
    EXPECT_EQ(component.gain, value);
  }
}

TEST(Property, IsNamedInTheErrorWhenItRejectsAValue) {
  Everything component;
  EXPECT_EQ(reason(component.count, "11"),
            "error: property 'count' cannot be '11'; it takes a whole number, 1 to 10");
  EXPECT_EQ(reason(component.gain, "-0.1"),
            "error: property 'gain' cannot be '-0.1'; it takes a number, at least 0, in 1/s");
  EXPECT_EQ(
      reason(component.gain, "5 1/s"),
      "error: property 'gain' cannot be '5 1/s'; it takes a number, at least 0, in 1/s, without the unit");
  EXPECT_EQ(reason(component.enabled, "yes"),
            "error: property 'enabled' cannot be 'yes'; it takes true or false");
  EXPECT_EQ(component.count, 3);
  EXPECT_EQ(component.gain, 1.5);
  EXPECT_TRUE(component.enabled);
}

TEST(Property, RejectsTextThatIsNotANumber) {
  Everything component;
  for (const char* text :
       {"", " 1", "1 ", "1,5", "nan", "-nan", "inf", "0x10", "1e999", "++1", "+-1", "one"}) {
    EXPECT_THAT(reason(component.free, text), HasSubstr("'free'")) << text;
    EXPECT_THAT(reason(component.count, text), HasSubstr("'count'")) << text;
  }
  EXPECT_THAT(reason(component.wide, "1.5"), HasSubstr("a whole number"));
}

TEST(Property, RejectsANumberThatItsTypeCannotHold) {
  Everything component;
  EXPECT_THAT(reason(component.wide, "9223372036854775808"), HasSubstr("'wide'"));
  EXPECT_THAT(reason(component.count, "4294967297"), HasSubstr("'count'"));  // would be 1 if truncated
  EXPECT_THAT(reason(component.narrow, "-1e39"), HasSubstr("'narrow'"));     // too large for a float
  EXPECT_EQ(component.narrow, 0.0f);
}

TEST(Property, AcceptsOnlyValuesWithinItsBounds) {
  Everything component;
  EXPECT_EQ(reason(component.count, "1"), "");
  EXPECT_EQ(reason(component.count, "10"), "");
  EXPECT_NE(reason(component.count, "0"), "");
  EXPECT_EQ(reason(component.gain, "0"), "");
}

TEST(Property, CanBeDeclaredWithoutAComponent) {
  static_cast<void>(take_loose_properties());
  Property<double> speed{"speed", 0.5, {.unit = "m/s", .min = 0.0, .max = 2.0}};
  Property<std::string> label{"label", "none"};
  { const Property<bool> gone{"gone", true}; }
  EXPECT_EQ(take_loose_properties(), (std::vector<PropertyBase*>{&speed, &label}));
  EXPECT_TRUE(take_loose_properties().empty());
}

TEST(Property, RemembersItsDefaultAfterItIsSet) {
  Everything component;
  ASSERT_TRUE(component.count.assign("7"));
  EXPECT_EQ(component.count.default_text(), "3");
  EXPECT_EQ(component.count.min_text(), "1");
  EXPECT_EQ(component.count.max_text(), "10");
  EXPECT_EQ(component.gain.max_text(), "");
}

TEST(Property, MustHaveAUniqueNameThatIsNotReservedAndADefaultWithinItsRange) {
  struct Wrong : Component {
    Property<double> a{*this, "a", 1.0, {.min = 2.0}};
    Property<double> twice{*this, "twice", 1.0};
    Property<double> again{*this, "twice", 1.0};
    Property<std::string> level{*this, "log-level", "info"};
    void run(const Cycle&) noexcept override {}
  } wrong;
  const Problems problems = check_declared(wrong.properties(), "it");
  EXPECT_EQ(
      to_text(problems),
      "error: it has a property 'a' whose default 1 is out of its range: at least 2; "
      "change the default or the range\n"
      "error: it has two properties 'twice'; give each a different name\n"
      "error: it declares property 'log-level', but every module already has this property, for the level "
      "of its log; give the property another name");
  EXPECT_TRUE(check_declared(Everything{}.properties(), "it").empty());
}

// Declares the same properties as the macros of <takt/property.h> would.
struct CProperties {
  double number = 0.5;
  std::int64_t integer = 3;
  int flag = 1;
  const char* text = "none";
  takt_property all[4] = {
      {"number", TAKT_IS_NUMBER, &number, 0, 2, 0, 0, "m/s", "Of the belt.", nullptr},
      {"integer", TAKT_IS_INTEGER, &integer, 0, 0, 1, INT64_MAX, "", "", nullptr},
      {"flag", TAKT_IS_FLAG, &flag, 0, 0, 0, 0, "", "", nullptr},
      {"text", TAKT_IS_STRING, &text, 0, 0, 0, 0, "", "", nullptr},
  };

  CProperties() {
    static_cast<void>(take_loose_properties());
    for (takt_property& property : all) takt_add_property(&property);
    taken = take_loose_properties();
  }
  ~CProperties() {
    for (takt_property& property : all) takt_remove_property(&property);
  }
  CProperties(const CProperties&) = delete;
  CProperties& operator=(const CProperties&) = delete;

  std::vector<PropertyBase*> taken;
};

TEST(CProperty, DescribesItsDeclarationAsText) {
  const CProperties c;
  ASSERT_EQ(c.taken.size(), 4U);
  EXPECT_EQ(c.taken[0]->range_text(), "0 to 2");
  EXPECT_EQ(c.taken[0]->unit(), "m/s");
  EXPECT_EQ(c.taken[0]->text(), "Of the belt.");
  EXPECT_EQ(c.taken[0]->default_text(), "0.5");
  EXPECT_EQ(c.taken[1]->range_text(), "at least 1");
  EXPECT_STREQ(to_text(c.taken[2]->type()), "bool");
  EXPECT_EQ(c.taken[3]->default_text(), "none");
}

TEST(CProperty, ChangesItsVariableOnlyWhenTheProposedValueIsTakenOver) {
  const CProperties c;
  EXPECT_EQ(c.number, 0.5);
  EXPECT_STREQ(c.text, "none");
  ASSERT_TRUE(c.taken[0]->propose("1.25"));
  EXPECT_EQ(c.number, 0.5) << "a hook may be running";
  c.taken[0]->take_over();
  EXPECT_EQ(c.number, 1.25);
  EXPECT_FALSE(c.taken[1]->assign("0"));
  EXPECT_EQ(c.integer, 3);
  ASSERT_TRUE(c.taken[1]->assign("9000000000"));
  EXPECT_EQ(c.integer, 9000000000);
  ASSERT_TRUE(c.taken[2]->assign("false"));
  EXPECT_EQ(c.flag, 0);
  for (const char* text : {"short", "a text that has memory of its own, as it is long enough"}) {
    ASSERT_TRUE(c.taken[3]->assign(text));
    EXPECT_STREQ(c.text, text);
  }
}

TEST(Property, AcceptsOnlyItsChoices) {
  Everything component;
  Property<std::string> mode{component, "mode", "slow", {.choices = {"slow", "fast", "off"}}};
  EXPECT_EQ(mode.range_text(), "slow, fast or off");
  EXPECT_TRUE(mode.assign("fast"));
  const auto rejected = mode.assign("Fast");
  ASSERT_FALSE(rejected);
  EXPECT_EQ(in_words(rejected.problems()),
            "property 'mode' cannot be 'Fast'; it takes text, slow, fast or off");
  EXPECT_EQ(mode.value(), "fast");
}

TEST(Property, CanHaveItsRangeNarrowedByTheModule) {
  Everything component;
  Property<double> cutoff{component, "cutoff", 10, {.unit = "Hz", .min = 0, .max = 1000}};
  EXPECT_TRUE(cutoff.narrow(1, 450, "at a period of 1 ms"));
  const auto rejected = cutoff.assign("500");
  ASSERT_FALSE(rejected);
  EXPECT_EQ(in_words(rejected.problems()),
            "property 'cutoff' cannot be '500'; it takes a number, 1 to 450 at a period of 1 ms, in Hz");
  EXPECT_TRUE(cutoff.narrow({}, 5000, "at a period of 100 us"));  // narrow() does not raise the maximum, 450
  EXPECT_FALSE(cutoff.assign("451"));
  EXPECT_FALSE(cutoff.narrow({}, 5, "at a period of 90 ms"));  // fails, because the current value is 10
}

}  // namespace
}  // namespace takt::property_test
