#include "web/recent_faults.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace takt::tool::web::recent_faults_test {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kBegin_ns = 1'700'000'000'000'000'000;

model::Fault fault(std::uint64_t sequence, Nanoseconds since, const std::string& device = "robot") {
  return {.sequence = sequence,
          .time_ns = kBegin_ns + since.count(),
          .device = device,
          .module = "arm",
          .kind = model::FaultKind::overrun};
}

nlohmann::json object(const std::string& members) { return nlohmann::json::parse("{" + members + "}"); }

std::vector<std::uint64_t> numbers(const nlohmann::json& answer) {
  std::vector<std::uint64_t> found;
  for (const auto& event : answer["events"]) found.push_back(event["sequence"]);
  return found;
}

/// All events, as a page requests them: the newest, then the others in parts.
std::vector<std::uint64_t> all(const RecentFaults& faults) {
  auto answer = object(faults.newest());
  auto found = numbers(answer);
  while (answer["older"] != 0) {
    answer = object(faults.before(answer["older"]));
    EXPECT_LE(answer["events"].size(), RecentFaults::kMostAtOnce);
    const auto older = numbers(answer);
    found.insert(found.begin(), older.begin(), older.end());
  }
  return found;
}

std::vector<std::uint64_t> range(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> made;
  for (std::uint64_t i = first; i <= last; ++i) made.push_back(i);
  return made;
}

TEST(RecentFaults, ReturnsAllEventsOfTheLastHourInParts) {
  RecentFaults faults;
  for (std::uint64_t i = 1; i <= 5001; ++i) faults.add(fault(i, i * 100ms));
  EXPECT_EQ(object(faults.newest())["events"].size(), RecentFaults::kNewest);
  EXPECT_EQ(all(faults), range(1, 5001));
  EXPECT_EQ(object(faults.newest())["complete_since_ms"], 0);
}

TEST(RecentFaults, ForgetsEventsThatAreOlderThanAnHourIfThereAreMany) {
  RecentFaults faults;
  for (std::uint64_t i = 1; i <= 700; ++i) faults.add(fault(i, i * 10s));
  EXPECT_EQ(all(faults), range(201, 700)) << "the newest 500 events of any age";
  for (std::uint64_t i = 701; i <= 1300; ++i) faults.add(fault(i, 7000s + (i - 700) * 1s));
  EXPECT_EQ(all(faults).front(), 400) << "the last event is at 7600 s, the first one at 4000 s";
  EXPECT_EQ(object(faults.newest())["complete_since_ms"],
            (kBegin_ns + Nanoseconds{3990s}.count()) / 1'000'000);
}

TEST(RecentFaults, KeepsNoMoreThanItsLimit) {
  RecentFaults faults;
  for (std::uint64_t i = 1; i <= RecentFaults::kMost + 1; ++i) faults.add(fault(i, i * 1us));
  EXPECT_EQ(all(faults), range(2, RecentFaults::kMost + 1));
  EXPECT_EQ(object(faults.newest())["complete_since_ms"], kBegin_ns / 1'000'000);
}

TEST(RecentFaults, InsertsTheEventsOfARecordByTimeAndOnce) {
  RecentFaults faults;
  faults.add(fault(3, 3s));
  faults.add(fault(6, 6s));
  faults.add_record({fault(1, 1s), fault(3, 3s), fault(5, 5s)}, true);
  EXPECT_EQ(all(faults), (std::vector<std::uint64_t>{1, 3, 5, 6}));
  faults.add_record({fault(2, 2s, "line"), fault(4, 4s, "line")}, false);
  EXPECT_EQ(all(faults), range(1, 6));
  EXPECT_EQ(object(faults.newest())["complete_since_ms"], (kBegin_ns + Nanoseconds{2s}.count()) / 1'000'000)
      << "the record of the device line begins there";
}

TEST(RecentFaults, ReturnsNoEventsBeforeANumberFromTheTimeBeforeARecord) {
  RecentFaults faults;
  for (std::uint64_t i = 1; i <= 600; ++i) faults.add(fault(i, i * 1s));
  const std::uint64_t former = object(faults.newest())["older"];
  faults.add_record({fault(601, 0s)}, true);
  EXPECT_EQ(numbers(object(faults.before(former))), std::vector<std::uint64_t>{});
  EXPECT_EQ(numbers(object(faults.before(0))), std::vector<std::uint64_t>{});
  EXPECT_EQ(numbers(object(faults.before(UINT64_MAX))), std::vector<std::uint64_t>{});
  EXPECT_EQ(all(faults).size(), 601);
}

}  // namespace
}  // namespace takt::tool::web::recent_faults_test
