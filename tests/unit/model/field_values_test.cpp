#include <takt/model/field_values.hpp>

#include <gtest/gtest.h>

namespace takt::model::field_values_test {
namespace {

Field of(std::string name, Scalar scalar) {
  Field field;
  field.name = std::move(name);
  field.scalar = scalar;
  return field;
}

Type grip() {
  Field kind = of("kind", Scalar::text);
  kind.bound = 15;
  Field mode = of("mode", Scalar::enumeration);
  mode.enumerators = {"OFF", "ON"};
  Field pose = of("pose", Scalar::structure);
  pose.type_name = "t::Pose";
  pose.fields = {of("x", Scalar::float64), of("y", Scalar::float64)};
  Field way = of("way", Scalar::float64);
  way.sequence = 4;
  return {"t::Grip", {of("force", Scalar::float64), kind, mode, pose, way, of("hold", Scalar::boolean)}};
}

std::string json(const std::vector<std::string>& words) {
  const auto result = json_of_input(grip(), words);
  return result ? *result : "error: " + to_text(result.problems());
}

TEST(FieldValues, MayOmitTheQuotesAroundStringsAndEnumerators) {
  EXPECT_EQ(json({}), "{}");
  EXPECT_EQ(json({"force=2.5", "kind=box", "mode=ON", "pose.x=1", "pose.y=-2", "way=[1,2]", "hold=true"}),
            R"({"force":2.5,"kind":"box","mode":"ON","pose":{"x":1,"y":-2},"way":[1,2],"hold":true})");
  EXPECT_EQ(json({R"(kind="a=b")"}), R"({"kind":"a=b"})");
  EXPECT_EQ(json({"kind=12"}), R"({"kind":"12"})")
      << "a string field that looks like a number stays a string";
  EXPECT_EQ(json({"kind="}), R"({"kind":""})");
  EXPECT_EQ(json({"force=NaN"}), R"({"force":"NaN"})");
  EXPECT_EQ(json({R"(pose={"x":1})"}), R"({"pose":{"x":1}})");
}

TEST(FieldValues, AreEncodedAsASample) {
  for (const auto& words : {std::vector<std::string>{"force=2.5", "mode=ON", "way=[1,2]"},
                            std::vector<std::string>{R"({"force":2.5,"mode":"ON","way":[1,2]})"}}) {
    const auto bytes = sample_bytes(grip(), json(words));
    ASSERT_TRUE(bytes.ok()) << to_text(bytes.problems());
    EXPECT_EQ(
        sample_json(grip(), bytes->data(), bytes->size()),
        R"({"force": 2.5, "kind": "", "mode": "ON", "pose": {"x": 0, "y": 0}, "way": [1, 2], "hold": false})");
  }
}

TEST(FieldValues, MayBeGivenAsOneJsonObject) { EXPECT_EQ(json({R"( {"force": 1})"}), R"( {"force": 1})"); }

TEST(FieldValues, ReportEachMistakeWithAFix) {
  EXPECT_EQ(json({"forse=1"}), "error: t::Grip: error: has no field 'forse'; did you mean force?");
  EXPECT_EQ(json({"pose.z=1"}), "error: t::Grip.pose: error: has no field 'z'; use x or y");
  EXPECT_EQ(
      json({"force"}),
      "error: t::Grip: error: 'force' does not have the form field=value; write field=value, or one object "
      "{\"field\": value}");
  EXPECT_EQ(json({"=1"}).find("error: t::Grip: error: '=1' does not have the form field=value"), 0U);
  EXPECT_EQ(json({"force=1", "force=2"}), "error: t::Grip.force: error: is given twice; give it one value");
  EXPECT_EQ(json({"pose=1", "pose.x=2"}),
            "error: t::Grip.pose: error: is given twice; write its value once, as JSON");
  EXPECT_EQ(json({"pose.x=2", "pose=1"}), "error: t::Grip.pose: error: is given twice; give it one value");
  EXPECT_EQ(json({"force.x=1"}),
            "error: t::Grip.force: error: has no named fields; write its value once, as JSON");
  EXPECT_EQ(json({"way.x=1"}),
            "error: t::Grip.way: error: has no named fields; write its value once, as JSON");
}

}  // namespace
}  // namespace takt::model::field_values_test
