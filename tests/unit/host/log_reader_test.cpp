#include <takt/host/log_reader.hpp>

#include <gmock/gmock.h>

#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include <takt/log.h>
#include <takt/component.hpp>
#include <takt/component/current_cycle.hpp>

namespace takt::host::log_reader_test {
namespace {

using channel::LogRing;
using testing::Each;
using testing::ElementsAre;

/// Makes the test's thread run a module, so that log calls on this thread write into the ring of the module.
class ModuleLog : public testing::Test {
 protected:
  void SetUp() override { serve_cycle(&cycle_, ring_.get()); }
  void TearDown() override { serve_cycle(nullptr); }
  std::vector<std::string> lines() {
    std::vector<std::string> all;
    while (auto line = reader_.next(now_)) all.push_back(line->text);
    return all;
  }

  Cycle cycle_{.number = 17, .time = {}, .period = {}, .start = from_ns(5'000)};
  std::unique_ptr<LogRing> ring_ = std::make_unique<LogRing>();
  LogReader reader_{*ring_};
  Instant now_ = from_ns(1'000'000);
};

TEST_F(ModuleLog, CarriesLevelReleaseTimeAndText) {
  log().warning("lost the part at {:.2f} m", 1.234);
  const auto line = reader_.next(now_);
  ASSERT_TRUE(line);
  EXPECT_EQ(line->level, LogLevel::warning);
  EXPECT_EQ(line->release, 17U);
  EXPECT_EQ(line->time_ns, 5'000);
  EXPECT_EQ(line->text, "lost the part at 1.23 m");
  EXPECT_FALSE(reader_.next(now_));
}

TEST_F(ModuleLog, CopiesArgumentsOfEachTypeAsValues) {
  enum class Colour : std::uint8_t { red = 3 };
  std::string text = "part";
  log().info("{} {} {} {} {} {}", true, 'c', std::int8_t{-5}, std::uint64_t{1} << 63, 0.1F, Colour::red);
  log().info("{} {:>6} {}", text, "right", std::string_view{"view"});
  text = "gone";
  EXPECT_THAT(lines(),
              ElementsAre("true c -5 9223372036854775808 0.10000000149011612 3", "part  right view"));
}

TEST_F(ModuleLog, FormatsTheConversionsOfPrintf) {
  takt_log(TAKT_LOG_INFO, "%d %5u|%-5d|%05d %x %lld %zu %c%%", -1, 3U, 4, 5, 255U, -6LL, std::size_t{7}, 'x');
  takt_log(TAKT_LOG_INFO, "%.2f %8.1e %s {} %10s", 1.005, 12345.0, "text", "right");
  EXPECT_THAT(lines(), ElementsAre("-1     3|4    |00005 ff -6 7 x%", "1.00  1.2e+04 text {}      right"));
}

TEST_F(ModuleLog, LeavesOutLinesBelowTheLevel) {
  log().debug("hidden");
  ring_->level = static_cast<std::uint32_t>(LogLevel::debug);
  log().debug("shown");
  ring_->level = static_cast<std::uint32_t>(LogLevel::error);
  log().warning("hidden");
  takt_log(TAKT_LOG_WARNING, "hidden");
  log().error("failed");
  EXPECT_THAT(lines(), ElementsAre("shown", "failed"));
}

TEST_F(ModuleLog, DropsAndCountsLinesWhileTheRingIsFull) {
  for (std::size_t i = 0; i < LogRing::kRecords + 3; ++i) log().warning("{}", i);
  takt_log(TAKT_LOG_ERROR, "no room");
  const auto first = lines();
  EXPECT_EQ(first.size(), LogRing::kRecords);
  EXPECT_EQ(first.back(), std::to_string(LogRing::kRecords - 1));
  EXPECT_THAT(reader_.lost(), ElementsAre(0, 1, 3, 0, 0));
  EXPECT_THAT(reader_.lost(), Each(0));
  log().info("again");
  EXPECT_THAT(lines(), ElementsAre("again"));
}

TEST_F(ModuleLog, KeepsRoomForErrorsAndWarningsInTheRing) {
  constexpr std::size_t kOthers = LogRing::kRecords - LogRing::kReserved;
  for (int round = 0; round < 5; ++round) {  // the free records begin at a different position in each round
    log().error("first");
    for (std::size_t i = 0; i < LogRing::kRecords; ++i) log().info("{}", i);
    log().debug("hidden");
    log().warning("half");
    log().error("failed");
    const auto all = lines();
    ASSERT_EQ(all.size(), kOthers + 2);
    EXPECT_EQ(all[0], "first");
    EXPECT_EQ(all[kOthers - 1], std::to_string(kOthers - 2));
    EXPECT_EQ(all[kOthers], "half");
    EXPECT_EQ(all[kOthers + 1], "failed");
    EXPECT_THAT(reader_.lost(), ElementsAre(0, 0, 0, LogRing::kReserved + 1, 0));
  }
}

TEST_F(ModuleLog, KeepsEveryLineOfSeveralThreads) {
  constexpr int kThreads = 4;
  constexpr std::uint64_t kLines = 20'000;
  std::atomic<int> open{kThreads};
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      serve_cycle(&cycle_, ring_.get());
      for (std::uint64_t i = 0; i < kLines; ++i) log().info("{}", static_cast<std::uint64_t>(t) * kLines + i);
      serve_cycle(nullptr);
      --open;
    });
  }
  std::uint64_t seen = 0;
  std::uint64_t lost = 0;
  std::vector<std::uint64_t> next(kThreads);
  while (true) {
    const bool last = open == 0;
    while (auto line = reader_.next(now_)) {
      const std::uint64_t value = std::stoull(line->text);
      ASSERT_GE(value % kLines, next[value / kLines]) << "a line came twice or out of order";
      next[value / kLines] = value % kLines + 1;
      ++seen;
    }
    for (const std::uint64_t count : reader_.lost()) lost += count;
    if (last) break;
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(seen + lost, kThreads * kLines);
}

TEST_F(ModuleLog, SkipsARecordWhoseWriterDied) {
  ring_->claimed = 1;  // as if the writer had claimed the record and then died
  log().info("after");
  EXPECT_TRUE(lines().empty());
  now_ += LogReader::kPatience;
  EXPECT_THAT(lines(), ElementsAre());
  EXPECT_THAT(lines(), ElementsAre("after"));
  EXPECT_THAT(reader_.lost(), ElementsAre(1, 0, 0, 0, 0));
}

TEST_F(ModuleLog, DropsLinesOfThreadsThatRunNoModule) {
  std::thread{[] { log().info("nobody hears this"); }}.join();
  EXPECT_TRUE(lines().empty());
}

TEST_F(ModuleLog, ShortensLinesThatDoNotFit) {
  const std::string large(10'000, 'x');
  log().info("{}|{}", large, large);
  takt_log(TAKT_LOG_INFO, "%s", large.c_str());
  for (const std::string& line : lines()) {
    EXPECT_GT(line.size(), 100U);
    EXPECT_LT(line.size(), 300U);
  }
}

TEST_F(ModuleLog, PrintsNoControlCharacters) {
  log().info("{}", "a\n\033[31mb\xff");
  const auto all = lines();
  ASSERT_EQ(all.size(), 1U);
  for (const char c : all[0]) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
}

/// Adds a record whose format does not come from a log call, as if the module had overwritten the ring.
/// Returns the text of the line that the reader makes from the record.
std::string text_of(ModuleLog&, LogRing& ring, LogReader& reader, const std::string& format, bool percent) {
  const channel::LogArgument arguments[] = {{channel::LogArgumentKind::natural, 1'000'000'000},
                                            {channel::LogArgumentKind::text, 4, "text"}};
  ring.add({.level = 3,
            .percent = percent,
            .time_ns = 0,
            .cycle = 0,
            .format = format.data(),
            .format_size = format.size()},
           arguments, 2);
  return reader.next(from_ns(0))->text;
}

TEST_F(ModuleLog, PrintsAnInvalidOrHugeFormatUnchangedWithTheArguments) {
  const std::string after = " (this format does not fit its arguments: 1000000000, text)";
  for (const char* format :
       {"{:1000000000}", "{:{}}", "{:.{}}", "{:.999999999f}", "{", "}", "{0", "{:s}", "{2}", "{x}", "{1:d}"})
    EXPECT_EQ(text_of(*this, *ring_, reader_, format, false), format + after);
  for (const char* format : {"%1000000000d", "%.999999999f"})
    EXPECT_EQ(text_of(*this, *ring_, reader_, format, true), format + after);
  for (const char* format : {"%n", "%", "%*d"})
    EXPECT_EQ(text_of(*this, *ring_, reader_, format, true), format);
}

TEST_F(ModuleLog, SurvivesAnOverwrittenRing) {
  std::mt19937_64 random{1};
  for (int round = 0; round < 2'000; ++round) {
    for (int i = 0; i < 10; ++i) log().info("{} {}", i, "text");
    auto* const bytes = reinterpret_cast<unsigned char*>(ring_.get());
    for (int i = 0; i < 200; ++i) {
      // Half of the writes change only the states of records, so that the reader takes these records for
      // complete ones.
      const std::size_t at = i % 2 == 0 ? random() % sizeof(LogRing)
                                        : (random() % LogRing::kRecords) * sizeof(channel::LogRecord) + 64;
      const std::uint64_t value = i % 3 == 0 ? random() : random() % 4;
      std::memcpy(bytes + std::min(at, sizeof(LogRing) - sizeof value), &value, sizeof value);
    }
    for (std::size_t i = 0; i < LogRing::kRecords; ++i) {
      if (const auto line = reader_.next(now_)) {
        EXPECT_LT(line->text.size(), 2'000U);
      }
      now_ += LogReader::kPatience;
    }
    static_cast<void>(reader_.lost());
  }
}

}  // namespace
}  // namespace takt::host::log_reader_test
