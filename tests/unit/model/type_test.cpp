#include <takt/model/type.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model::type_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kPlan =
    R"({"name":"motion::Plan","fields":[)"
    R"({"name":"mode","type":"enum","of":"motion::Mode","enumerators":["OFF","ON"]},)"
    R"({"name":"label","type":"string","bound":15},)"
    R"({"name":"way","type":"double","unit":"mm","array":[2,6],"sequence":8,"elements":[3]},)"
    R"({"name":"start","type":"struct","of":"motion::Pose","fields":[{"name":"x","type":"long"}]}]})";

/// Returns the problems that parse_type() finds in the description of a type.
std::vector<std::string> problems_of(const std::string& text) {
  const auto type = parse_type(text);
  std::vector<std::string> lines;
  if (!type.ok())
    for (const Problem& problem : type.problems()) lines.push_back(problem.where + " " + problem.what);
  return lines;
}
std::vector<std::string> problems_with(const std::string& fields) {
  return problems_of(R"({"name":"T","fields":[)" + fields + "]}");
}
Type type_of(const std::string& fields) {
  return parse_type(R"({"name":"T","fields":[)" + fields + "]}").value();
}

TEST(Type, IsParsedFromItsDescription) {
  const auto type = parse_type(kPlan);
  ASSERT_TRUE(type.ok()) << to_text(type.problems());
  EXPECT_EQ(type->name, "motion::Plan");
  ASSERT_EQ(type->fields.size(), 4U);
  const Field mode{.name = "mode",
                   .scalar = Scalar::enumeration,
                   .type_name = "motion::Mode",
                   .enumerators = {"OFF", "ON"}};
  EXPECT_EQ(type->fields[0], mode);
  const Field label{.name = "label", .scalar = Scalar::text, .bound = 15};
  EXPECT_EQ(type->fields[1], label);
  const Field way{.name = "way",
                  .scalar = Scalar::float64,
                  .unit = "mm",
                  .dimensions = {2, 6},
                  .sequence = 8,
                  .elements = {3}};
  EXPECT_EQ(type->fields[2], way);
  EXPECT_EQ(type->fields[3].type_name, "motion::Pose");
  EXPECT_EQ(type->fields[3].fields.at(0).name, "x");
}

TEST(Type, IsWrittenBackAsTheSameDescription) { EXPECT_EQ(to_text(*parse_type(kPlan)), kPlan); }

TEST(Type, DiffersIfAnyPartOfTheDescriptionDiffers) {
  const Type plan = *parse_type(kPlan);
  for (const auto& [was, is] :
       std::vector<std::pair<std::string, std::string>>{{"motion::Plan", "motion::Plam"},
                                                        {"\"OFF\"", "\"OUT\""},
                                                        {"motion::Mode", "motion::Node"},
                                                        {":15", ":16"},
                                                        {"double", "float"},
                                                        {"\"mm\"", "\"m\""},
                                                        {"[2,6]", "[6,2]"},
                                                        {":8", ":9"},
                                                        {"[3]", "[1]"},
                                                        {"motion::Pose", "motion::Port"},
                                                        {"\"x\"", "\"y\""},
                                                        {"long", "unsigned long"}}) {
    std::string text = kPlan;
    text.replace(text.find(was), was.size(), is);
    const auto other = parse_type(text);
    ASSERT_TRUE(other.ok()) << text;
    EXPECT_NE(*other, plan) << is;
  }
}

TEST(Type, HasAKeywordForEachScalar) {
  for (const auto* word : {"boolean", "octet", "char", "int8", "short", "unsigned short", "long",
                           "unsigned long", "long long", "unsigned long long", "float", "double"}) {
    const Type type = type_of(R"({"name":"x","type":")" + std::string{word} + "\"}");
    EXPECT_STREQ(to_text(type.fields[0].scalar), word);
  }
  EXPECT_STREQ(to_text(Scalar::text), "string");
  EXPECT_STREQ(to_text(Scalar::enumeration), "enum");
  EXPECT_STREQ(to_text(Scalar::structure), "struct");
}

// ---- Types that a port cannot have

TEST(Type, RejectsAStringWithoutABound) {
  EXPECT_THAT(problems_with(R"({"name":"x","type":"string"})"),
              ElementsAre("T.x is a string without a bound"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"string","bound":0})"),
              ElementsAre("T.x is a string without a bound"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"string","bound":-1})"),
              ElementsAre("T.x is a string without a bound"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"string","bound":67108865})"),
              ElementsAre("T.x is a string without a bound"));
}

TEST(Type, RejectsASequenceOrArrayWithoutABound) {
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long","sequence":0})"),
              ElementsAre("T.x is a sequence without a bound"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long","sequence":1.5})"),
              ElementsAre("T.x is a sequence without a bound"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long","array":[3,0]})"),
              ElementsAre("T.x is an array without a size"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long","elements":[3]})"),
              ElementsAre("T.x has \"elements\" but is not a sequence"));
}

TEST(Type, RejectsASequenceWithinASequence) {
  const std::string inner = R"({"name":"in","type":"long","sequence":2})";
  const auto around = [](const std::string& fields, const std::string& more) {
    return R"({"name":"out","type":"struct","of":"U",)" + more + R"("fields":[)" + fields + "]}";
  };
  EXPECT_THAT(problems_with(around(inner, "")), ElementsAre());
  EXPECT_THAT(problems_with(around(inner, R"("array":[3],)")), ElementsAre());
  EXPECT_THAT(problems_with(around(inner, R"("sequence":3,)")),
              ElementsAre("T.out.in is a sequence within a sequence"));
  EXPECT_THAT(problems_with(around(around(inner, ""), R"("sequence":3,)")),
              ElementsAre("T.out.out.in is a sequence within a sequence"));
  // A struct may contain two sequences if neither contains the other.
  EXPECT_THAT(problems_with(around(R"({"name":"a","type":"long"})", R"("sequence":3,)") + "," + inner),
              ElementsAre());
}

TEST(Type, RejectsAKeyField) {
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long","key":true})"), ElementsAre("T.x is a key"));
}

TEST(Type, RejectsAnInvalidUnit) {
  for (const auto* const unit :
       {"7", "\"\"", "\"\u00b0C\"", "\"a\\nb\"", "\"a metre has more than 32 characters\""})
    EXPECT_THAT(problems_with(std::string{R"({"name":"x","type":"long","unit":)"} + unit + "}"),
                ElementsAre("T.x has no valid \"unit\""))
        << unit;
  for (const auto* const type :
       {R"("boolean")", R"("char")", R"("string","bound":3)", R"("enum","of":"E","enumerators":["A"])",
        R"("struct","of":"S","fields":[{"name":"y","type":"long"}])"})
    EXPECT_THAT(problems_with(std::string{R"({"name":"x","unit":"m","type":)"} + type + "}"),
                ElementsAre("T.x has a unit but is not a number"));
}

TEST(Type, RejectsUnknownFieldTypesAndJsonMembers) {
  EXPECT_THAT(problems_with(R"({"name":"x","type":"wstring"})"), ElementsAre("T.x has no known type"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":7})"), ElementsAre("T.x has no known type"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long","bound":7})"),
              ElementsAre("T.x has the unknown member 'bound'"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long","optional":true})"),
              ElementsAre("T.x has the unknown member 'optional'"));
  EXPECT_THAT(problems_of(R"({"name":"T","keys":["x"],"fields":[{"name":"x","type":"long"}]})"),
              ElementsAre("T has the unknown member 'keys'"));
}

TEST(Type, RejectsMissingAndDuplicateNames) {
  EXPECT_THAT(problems_with(R"({"type":"long"})"), ElementsAre("T has no valid \"name\""));
  EXPECT_THAT(problems_with(R"({"name":"a.b","type":"long"})"), ElementsAre("T has no valid \"name\""));
  EXPECT_THAT(problems_with(R"({"name":"","type":"long"})"), ElementsAre("T has no valid \"name\""));
  EXPECT_THAT(problems_with(R"({"name":"3","type":"long"})"), ElementsAre("T has no valid \"name\""));
  EXPECT_THAT(problems_of(R"({"name":"a::","fields":[{"name":"x","type":"long"}]})"),
              ElementsAre("the type has no valid \"name\""));
  EXPECT_THAT(problems_of(R"({"name":"::a","fields":[{"name":"x","type":"long"}]})"),
              ElementsAre("the type has no valid \"name\""));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"enum","enumerators":["A"]})"),
              ElementsAre("T.x has no valid \"of\""));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"enum","of":"E","enumerators":[]})"),
              ElementsAre("T.x has no enumerators"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"enum","of":"E","enumerators":["A","A"]})"),
              ElementsAre("T.x has an enumerator without a unique name"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"struct","of":"S","fields":[]})"),
              ElementsAre("T.x has no fields"));
  EXPECT_THAT(problems_with(R"({"name":"x","type":"long"},{"name":"x","type":"long"})"),
              ElementsAre("T.x appears twice"));
}

TEST(Type, ReportsAllMistakesAtOnce) {
  EXPECT_THAT(
      problems_with(
          R"({"name":"a","type":"string"},{"name":"b","type":"any"},{"name":"c","type":"long","key":1},7)"),
      ElementsAre("T.a is a string without a bound", "T.b has no known type", "T.c is a key",
                  "T has a field that is not an object"));
}

TEST(Type, RejectsTextThatIsNotADescription) {
  for (const auto* text :
       {"", "{", "7", "[]", "null", "\"T\"", "{\"name\":\"T\"}", "{\"name\":\"T\",\"fields\":{}}",
        "{\"name\":\"T\",\"fields\":[]}", "\xff", "{\"fields\":[{\"name\":\"x\",\"type\":\"long\"}]}"}) {
    EXPECT_FALSE(parse_type(text).ok()) << text;
  }
  EXPECT_FALSE(parse_type(std::string(100'000, '[')).ok());
  EXPECT_THAT(problems_of(std::string(kMaxDescription + 1, ' ')),
              ElementsAre(HasSubstr("the description has 1048577 bytes")));
}

// ---- Limits for a whole type

std::string nested(std::size_t structs) {
  std::string fields = R"({"name":"x","type":"long"})";
  for (std::size_t i = 1; i < structs; ++i)
    fields = R"({"name":"s","type":"struct","of":"S","fields":[)" + fields + "]}";
  return fields;
}

TEST(Type, LimitsTheDepthOfNestedStructs) {
  EXPECT_THAT(problems_with(nested(kMaxNesting)), ElementsAre());
  EXPECT_THAT(problems_with(nested(kMaxNesting + 1)),
              ElementsAre(HasSubstr("is a struct that is nested too deep")));
  EXPECT_FALSE(problems_with(nested(10'000)).empty());
}

TEST(Type, LimitsTheNumberOfFields) {
  std::string fields;
  for (std::size_t i = 0; i < kMaxFields; ++i)
    fields += R"({"name":"f)" + std::to_string(i) + R"(","type":"octet"},)";
  EXPECT_THAT(problems_with(fields.substr(0, fields.size() - 1)), ElementsAre());
  EXPECT_THAT(problems_with(fields + R"({"name":"x","type":"octet"})"), ElementsAre("T has too many fields"));
}

TEST(Type, LimitsTheSizeOfASample) {
  EXPECT_THAT(problems_with(R"({"name":"x","type":"octet","array":[67108860]})"), ElementsAre());
  EXPECT_THAT(problems_with(R"({"name":"x","type":"octet","array":[67108861]})"),
              ElementsAre("T a sample has more than 67108864 bytes"));
  EXPECT_THAT(problems_with(
                  R"({"name":"x","type":"octet","array":[67108864,67108864,67108864],"sequence":67108864})"),
              ElementsAre("T a sample has more than 67108864 bytes"));
}

// ---- Maximum sizes: 4 bytes of encapsulation and the fields, rounded up to a multiple of 4

TEST(MaxSize, IncludesPadding) {
  EXPECT_EQ(max_size(type_of(R"({"name":"a","type":"octet"})")), 8U);
  EXPECT_EQ(max_size(type_of(R"({"name":"a","type":"octet"},{"name":"b","type":"double"})")), 4 + 16U);
  EXPECT_EQ(max_size(type_of(R"({"name":"b","type":"double"},{"name":"a","type":"octet"})")), 4 + 12U);
  EXPECT_EQ(max_size(type_of(R"({"name":"a","type":"octet"},{"name":"b","type":"short"})")), 4 + 4U);
  EXPECT_EQ(max_size(type_of(R"({"name":"a","type":"string","bound":3})")), 4 + 8U);
  EXPECT_EQ(max_size(type_of(R"({"name":"a","type":"string","bound":4})")), 4 + 12U);
  EXPECT_EQ(max_size(type_of(R"({"name":"a","type":"double","sequence":2})")), 4 + 8 + 16U);
  EXPECT_EQ(max_size(type_of(R"({"name":"a","type":"double","array":[2],"sequence":2})")), 4 + 2 * (8 + 16U));
}

TEST(MaxSize, IsTheSameForAnArrayAndForItsElementsAsSingleFields) {
  // The size of an element is not a multiple of its alignment. So the padding differs from element to
  // element.
  const std::string odd = R"({"name":"n","type":"long"},{"name":"o","type":"string","bound":2})";
  for (std::size_t n = 1; n < 40; ++n) {
    std::string each;
    for (std::size_t i = 0; i < n; ++i)
      each += (i == 0 ? "" : ",") +
              (R"({"name":"s)" + std::to_string(i) + R"(","type":"struct","of":"S","fields":[)" + odd + "]}");
    const Type array =
        type_of(R"({"name":"o","type":"octet"},{"name":"s","type":"struct","of":"S","array":[)" +
                std::to_string(n) + R"(],"fields":[)" + odd + "]}");
    EXPECT_EQ(max_size(array), max_size(type_of(R"({"name":"o","type":"octet"},)" + each))) << n;
  }
}

// ---- Samples of {octet kind; string<3> label; sequence<Mode, 2> modes}. The encapsulation and `kind` take 8
// bytes; the length of `label` is at byte 8.

class Sample : public testing::Test {
 protected:
  const Type type =
      type_of(R"({"name":"kind","type":"octet"},{"name":"label","type":"string","bound":3},)"
              R"({"name":"modes","type":"enum","of":"Mode","enumerators":["OFF","ON"],"sequence":2})");
  std::vector<std::uint8_t> right{0, 1, 0, 0, 7, 0, 0, 0, 3, 0, 0, 0, 'a', 'b',
                                  0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0,   0};
  bool is(const std::vector<std::uint8_t>& bytes) const {
    return is_sample(type, reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
  }
  bool with(std::size_t at, std::uint8_t value) const {
    auto bytes = right;
    bytes.at(at) = value;
    return is(bytes);
  }
};

TEST_F(Sample, IsInvalidIfTruncatedOrOutOfBounds) {
  ASSERT_TRUE(is(right));
  EXPECT_FALSE(is({}));
  for (std::size_t size = 0; size < right.size(); ++size)
    EXPECT_FALSE(is({right.begin(), right.begin() + static_cast<std::ptrdiff_t>(size)})) << size;
  EXPECT_FALSE(with(0, 1));  // an invalid encapsulation
  EXPECT_FALSE(with(1, 3));
  EXPECT_TRUE(with(3, 1));     // the options may have any value
  EXPECT_TRUE(with(5, 0xEE));  // the padding may have any value
  EXPECT_FALSE(with(8, 0));    // an invalid length of `label`
  EXPECT_FALSE(with(8, 2));
  EXPECT_FALSE(with(8, 5));
  EXPECT_FALSE(with(11, 0x80));
  EXPECT_FALSE(with(13, 0));  // a zero before the end of `label`
  EXPECT_FALSE(with(14, 'c'));
  EXPECT_FALSE(with(16, 3));  // a length of `modes` above its bound
  EXPECT_FALSE(with(16, 1));  // a complete mode would follow the sequence
  EXPECT_FALSE(with(20, 2));  // an undefined enumerator in `modes`
  EXPECT_FALSE(with(27, 1));
}

TEST_F(Sample, MayBeBigEndian) {
  EXPECT_TRUE(is({0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 3, 'a', 'b', 0, 0, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_FALSE(is({0, 0, 0, 0, 7, 0, 0, 0, 3, 0, 0, 0, 'a', 'b', 0, 0, 0, 0, 0, 1, 0, 0, 0, 1}));
}

TEST_F(Sample, IsPrintedAsJson) {
  EXPECT_EQ(sample_json(type, reinterpret_cast<const std::byte*>(right.data()), right.size()),
            R"({"kind": 7, "label": "ab", "modes": ["ON", "OFF"]})");
}

TEST_F(Sample, IsBuiltFromJson) {
  const auto bytes = sample_bytes(type, R"({"modes": ["ON", "OFF"], "kind": 7, "label": "ab"})");
  ASSERT_TRUE(bytes.ok());
  EXPECT_TRUE(std::equal(bytes->begin(), bytes->end(), right.begin(), right.end(),
                         [](std::byte a, std::uint8_t b) { return a == std::byte{b}; }));
}

TEST_F(Sample, HasZeroInFieldsMissingFromItsJson) {
  for (const auto* text : {"{}", "null", R"({"label": null})"}) {
    const auto bytes = sample_bytes(type, text);
    ASSERT_TRUE(bytes.ok());
    EXPECT_TRUE(is_sample(type, bytes->data(), bytes->size()));
    EXPECT_EQ(sample_json(type, bytes->data(), bytes->size()), R"({"kind": 0, "label": "", "modes": []})");
  }
}

/// Builds a sample with one field, described by `field`, from the JSON value `json`. Returns the sample's
/// value printed as JSON, or the first problem.
std::string through(const std::string& field, const std::string& json) {
  const Type type = type_of(R"({"name":"x",)" + field + "}");
  const auto bytes = sample_bytes(type, R"({"x": )" + json + "}");
  if (!bytes.ok())
    return bytes.problems()[0].where + " " + bytes.problems()[0].what + "; " + bytes.problems()[0].fix;
  EXPECT_TRUE(is_sample(type, bytes->data(), bytes->size()));
  const std::string text = sample_json(type, bytes->data(), bytes->size());
  return text.substr(6, text.size() - 7);
}

TEST(SampleJson, KeepsNumbersExactly) {
  EXPECT_EQ(through(R"("type":"unsigned long long")", "18446744073709551615"), "18446744073709551615");
  EXPECT_EQ(through(R"("type":"long long")", "-9223372036854775808"), "-9223372036854775808");
  EXPECT_EQ(through(R"("type":"int8")", "-128"), "-128");
  EXPECT_EQ(through(R"("type":"octet")", "255"), "255");
  EXPECT_EQ(through(R"("type":"double")", "0.1"), "0.1");
  EXPECT_EQ(through(R"("type":"float")", "0.1"), "0.1");
  EXPECT_EQ(through(R"("type":"double")", "5e-324"), "5e-324");
  EXPECT_EQ(through(R"("type":"double")", "7"), "7");
  EXPECT_EQ(through(R"("type":"double")", "-0.0"), "-0");
  EXPECT_EQ(through(R"("type":"double")", "\"NaN\""), "\"NaN\"");
  EXPECT_EQ(through(R"("type":"float")", "\"-Infinity\""), "\"-Infinity\"");
  EXPECT_EQ(through(R"("type":"boolean")", "true"), "true");
}

TEST(SampleJson, KeepsCharactersAndStringsExactly) {
  for (int c = 0; c < 256; ++c) {
    const Type type = type_of(R"({"name":"x","type":"char"})");
    const std::array<std::byte, 5> bytes{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0},
                                         static_cast<std::byte>(c)};
    const auto again = sample_bytes(type, sample_json(type, bytes.data(), bytes.size()));
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again->back(), bytes.back()) << c;
  }
  EXPECT_EQ(through(R"("type":"string","bound":9)", R"("\"\\\nä€")"), R"("\"\\\nä€")");
}

TEST(SampleJson, ReplacesInvalidUtf8) {
  const Type type = type_of(R"({"name":"x","type":"string","bound":3})");
  const std::array<std::uint8_t, 11> bytes{0, 1, 0, 0, 3, 0, 0, 0, 'a', 0xFF, 0};
  EXPECT_EQ(sample_json(type, reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()),
            "{\"x\": \"a\xEF\xBF\xBD\"}");
}

TEST(SampleJson, NestsOneListPerArrayDimension) {
  EXPECT_EQ(through(R"("type":"long","array":[2,3])", "[[1,2,3],[4,5,6]]"), "[[1, 2, 3], [4, 5, 6]]");
  EXPECT_EQ(through(R"("type":"long","array":[2],"sequence":3,"elements":[1])", "[[[1],[2]],[]]"),
            "[[[1], [2]], []]");
  EXPECT_EQ(through(R"("type":"struct","of":"S","array":[2],"fields":[{"name":"y","type":"octet"}])",
                    R"([{"y":1},{}])"),
            R"([{"y": 1}, {"y": 0}])");
}

TEST(SampleBytes, ReportTheFieldWhoseValueDoesNotFit) {
  EXPECT_EQ(through(R"("type":"octet")", "256"), "T.x cannot be 256; write a whole number from 0 to 255");
  EXPECT_EQ(through(R"("type":"octet")", "-1"), "T.x cannot be -1; write a whole number from 0 to 255");
  EXPECT_EQ(through(R"("type":"long")", "1.5"),
            "T.x cannot be 1.5; write a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(through(R"("type":"long long")", "9223372036854775808"),
            "T.x cannot be 9223372036854775808; write a whole number from -9223372036854775808 to "
            "9223372036854775807");
  EXPECT_EQ(through(R"("type":"unsigned long long")", "-1"),
            "T.x cannot be -1; write a whole number from 0 to 18446744073709551615");
  EXPECT_EQ(through(R"("type":"float")", "1e39"),
            "T.x cannot be 1e+39; write a number that a float can hold, or \"NaN\"");
  EXPECT_EQ(through(R"("type":"double")", "\"much\""),
            "T.x cannot be \"much\"; write a number that a double can hold, or \"NaN\"");
  EXPECT_EQ(through(R"("type":"boolean")", "1"), "T.x cannot be 1; write true or false");
  EXPECT_EQ(through(R"("type":"char")", "\"ab\""),
            "T.x cannot be \"ab\"; write a string of one Latin-1 character");
  EXPECT_EQ(through(R"("type":"string","bound":2)", "\"abc\""),
            "T.x cannot be \"abc\"; write a string of at most 2 bytes that contains no zero byte");
  EXPECT_EQ(through(R"("type":"string","bound":2)", "\"\\u0000\""),
            "T.x cannot be \"\\u0000\"; write a string of at most 2 bytes that contains no zero byte");
  EXPECT_EQ(through(R"("type":"enum","of":"E","enumerators":["OFF","ON"])", "\"On\""),
            "T.x cannot be \"On\"; did you mean ON?");
  EXPECT_EQ(through(R"("type":"enum","of":"E","enumerators":["OFF","ON"])", "1"),
            "T.x cannot be 1; use OFF or ON");
  EXPECT_EQ(through(R"("type":"long","array":[2])", "[1]"),
            "T.x cannot be a list of length 1; write a list of length 2");
  EXPECT_EQ(through(R"("type":"long","array":[2])", "[1,\"\"]"),
            "T.x[1] cannot be \"\"; write a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(through(R"("type":"long","sequence":2)", "[1,2,3]"),
            "T.x cannot be a list of length 3; write a list of length at most 2");
  EXPECT_EQ(through(R"("type":"struct","of":"S","fields":[{"name":"y","type":"octet"}])", R"({"z":1})"),
            "T.x has no field 'z'; use y");
  EXPECT_EQ(through(R"("type":"struct","of":"S","fields":[{"name":"y","type":"octet"}])", "3"),
            "T.x cannot be 3; write an object, {\"field\": value}");
}

TEST(SampleBytes, ReportEveryFieldWhoseValueDoesNotFit) {
  const Type type = type_of(R"({"name":"a","type":"octet"},{"name":"b","type":"octet","array":[3]})");
  const auto bytes = sample_bytes(type, R"({"a": 300, "b": [1, -1, true], "c": 0})");
  ASSERT_FALSE(bytes.ok());
  std::vector<std::string> where;
  for (const Problem& problem : bytes.problems()) where.push_back(problem.where);
  EXPECT_THAT(where, ElementsAre("T", "T.a", "T.b[1]", "T.b[2]"));
}

TEST(SampleBytes, CannotBeBuiltFromTextThatIsNotJson) {
  const Type type = type_of(R"({"name":"a","type":"octet"})");
  for (const std::string& text :
       {std::string{}, std::string{"{"}, std::string{"{'a': 1}"}, std::string(100'000, '[')}) {
    const auto bytes = sample_bytes(type, text);
    ASSERT_FALSE(bytes.ok());
    EXPECT_THAT(bytes.problems()[0].what, StartsWith("the sample is not JSON"));
  }
  // Valid JSON that is nested 100,000 deep must be rejected, and must not exhaust the stack.
  EXPECT_FALSE(sample_bytes(type, std::string(100'000, '[') + std::string(100'000, ']')).ok());
}

}  // namespace
}  // namespace takt::model::type_test
