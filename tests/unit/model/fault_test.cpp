#include <takt/model/fault.hpp>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>

namespace takt::model::fault_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

Fault fault(std::uint64_t sequence, FaultKind kind = FaultKind::error, const std::string& module = "servo") {
  return {.sequence = sequence,
          .time_ns = static_cast<std::int64_t>(sequence) * 100,
          .cell = "cell",
          .device = "robot",
          .module = module,
          .kind = kind,
          .error = "crash",
          .cause = "it \"fell\"\nover",
          .attachment = "/tmp/core",
          .count = 2,
          .cycle = 17};
}

TEST(Fault, SurvivesARoundTripThroughJson) {
  EXPECT_EQ(fault_from(parse_json(json_text(to_json(fault(3))))), fault(3));
  const Fault least{
      .sequence = 1, .time_ns = 1, .cell = "-", .device = "robot", .kind = FaultKind::node_start};
  EXPECT_EQ(fault_from(parse_json(json_text(to_json(least)))), least);
  EXPECT_TRUE(to_json(least).at("module").is_null());
  EXPECT_TRUE(to_json(least).at("cell").is_null());
  EXPECT_TRUE(to_json(least).at("cycle").is_null());
}

TEST(Fault, RejectsJsonThatIsNotAnEvent) {
  for (const char* text : {"{}", "[]", "1", R"({"kind": "error"})", "what"})
    EXPECT_EQ(fault_from(parse_json(text)), std::nullopt) << text;
  auto value = to_json(fault(1));
  value["kind"] = "fire";
  EXPECT_EQ(fault_from(value), std::nullopt);
}

TEST(FaultKind, HasAUniqueName) {
  const auto words = fault_words();
  ASSERT_THAT(words, SizeIs(kFaultKinds));
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto kind = static_cast<FaultKind>(i);
    EXPECT_EQ(to_text(kind), words[i]);
    EXPECT_EQ(fault_kind(words[i]), kind);
  }
  EXPECT_STREQ(to_text(static_cast<FaultKind>(99)), "?");
  EXPECT_EQ(fault_kind("?"), std::nullopt);
}

TEST(FaultFilter, SelectsMatchingEvents) {
  const std::vector<Fault> all{fault(1), fault(2, FaultKind::overrun), fault(3, FaultKind::overrun, "arm"),
                               fault(4, FaultKind::node_end, "")};
  const auto numbers = [&all](const FaultFilter& filter) {
    std::vector<std::uint64_t> found;
    for (const Fault& each : filter.of(all)) found.push_back(each.sequence);
    return found;
  };
  EXPECT_THAT(numbers({}), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(numbers({.module = "servo"}), ElementsAre(1, 2));
  EXPECT_THAT(numbers({.device = "line"}), IsEmpty());
  EXPECT_THAT(numbers({.kinds = {FaultKind::overrun, FaultKind::node_end}}), ElementsAre(2, 3, 4));
  EXPECT_THAT(numbers({.after = 2}), ElementsAre(3, 4));
  EXPECT_THAT(numbers({.since_ns = 300}), ElementsAre(3, 4));
  EXPECT_THAT(numbers({.kinds = {FaultKind::overrun}, .last = 1}), ElementsAre(3));
  EXPECT_THAT(numbers({.last = 0}), IsEmpty());
  EXPECT_THAT(numbers({.last = 9}), SizeIs(4));
}

TEST(FaultFilter, SurvivesARoundTripThroughJson) {
  const FaultFilter filter{
      .module = "servo", .kinds = {FaultKind::missed_rows}, .after = 7, .since_ns = 8, .last = 0};
  const auto read = filter_from(json_text(to_json(filter)));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(to_json(*read), to_json(filter));
  EXPECT_TRUE(filter_from("").ok());
  EXPECT_TRUE(filter_from("{}").ok());
}

TEST(FaultFilter, ReportsWhyItIsInvalid) {
  const auto why = [](const char* text) { return in_words(filter_from(text).problems()); };
  EXPECT_THAT(why("[]"), HasSubstr("not a JSON object"));
  EXPECT_THAT(why(R"({"kind": 1})"), HasSubstr("did you mean kinds"));
  EXPECT_THAT(why(R"({"kinds": ["overun"]})"), HasSubstr("did you mean overrun"));
  EXPECT_THAT(why(R"({"last": "many"})"), HasSubstr("cannot be read"));
  for (const char* number : {"-1", "1.5", "1e300", "-1e300", "18446744073709551616"}) {
    EXPECT_THAT(why(("{\"last\": " + std::string{number} + "}").c_str()), HasSubstr("must be a whole number of at least 0"))
        << number;
    EXPECT_THAT(why(("{\"after\": " + std::string{number} + "}").c_str()), HasSubstr("must be a whole number of at least 0"))
        << number;
  }
  EXPECT_THAT(why(R"({"since_ns": 1e300})"), HasSubstr("must be a whole number of at least 0"));
  EXPECT_THAT(why(R"({"since_ns": 9223372036854775808})"), HasSubstr("must be a whole number of at least 0"));
  EXPECT_EQ(filter_from(R"({"since_ns": -5})")->since_ns, -5);
}

TEST(FaultFilter, IgnoresDuplicateKinds) {
  std::string many = R"({"kinds": ["error")";
  for (int i = 0; i < 1000; ++i) many += R"(, "overrun", "error")";
  EXPECT_THAT(filter_from(many + "]}")->kinds, ElementsAre(FaultKind::error, FaultKind::overrun));
}

TEST(FaultKinds, AreReadFromACommaSeparatedList) {
  EXPECT_THAT(*kinds_from("error,missed-rows"), ElementsAre(FaultKind::error, FaultKind::missed_rows));
  for (const char* text : {"", "error,", ",error", "errors", "error,, overrun"})
    EXPECT_FALSE(kinds_from(text).ok()) << text;
  EXPECT_THAT(in_words(kinds_from("error,overun").problems()), HasSubstr("did you mean overrun"));
}

}  // namespace
}  // namespace takt::model::fault_test
