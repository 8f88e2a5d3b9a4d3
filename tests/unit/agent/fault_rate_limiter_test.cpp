#include <takt/agent/fault_rate_limiter.hpp>

#include <gmock/gmock.h>

#include <random>
#include <tuple>

namespace takt::agent::fault_rate_limiter_test {
namespace {

using model::Fault;
using model::FaultKind;
using std::chrono::milliseconds;
using testing::IsEmpty;
using testing::SizeIs;

class LimiterOfFaultEvents : public testing::Test {
 protected:
  void put(const std::string& module, FaultKind kind, std::uint64_t count = 1, const std::string& cause = {},
           const std::string& origin = {}) {
    filter_.put({.module = module, .kind = kind, .cause = cause, .count = count}, now_, origin);
  }
  void pass(Nanoseconds time) {
    now_ += time;
    filter_.step(now_);
  }
  std::uint64_t sum() const {
    std::uint64_t sum = 0;
    for (const Fault& fault : through_) sum += fault.count;
    return sum;
  }

  Instant now_ = from_ns(1'000'000'000'000);
  std::vector<Fault> through_;
  FaultRateLimiter filter_{[this](Fault fault) { through_.push_back(std::move(fault)); }};
};

TEST_F(LimiterOfFaultEvents, EmitsTheFirstEventAtOnce) {
  put("servo", FaultKind::overrun, 3);
  ASSERT_THAT(through_, SizeIs(1));
  EXPECT_EQ(through_[0].count, 3U);
}

TEST_F(LimiterOfFaultEvents, MergesFurtherEventsIntoOnePerSecond) {
  for (int i = 0; i < 2500; ++i) {
    put("servo", FaultKind::overrun, 1, "number " + std::to_string(i));
    pass(milliseconds{1});
  }
  ASSERT_THAT(through_, SizeIs(3));
  EXPECT_EQ(through_[0].count, 1U);
  EXPECT_EQ(through_[1].count, 999U);
  EXPECT_EQ(through_[1].cause, "number 999") << "the cause of the newest event";
  EXPECT_EQ(through_[2].count, 1000U);
  filter_.flush();
  EXPECT_EQ(sum(), 2500U);
}

TEST_F(LimiterOfFaultEvents, EmitsMergedEventsOneSecondAfterTheFirst) {
  put("servo", FaultKind::overrun);
  put("servo", FaultKind::overrun);
  pass(milliseconds{999});
  EXPECT_THAT(through_, SizeIs(1));
  pass(milliseconds{1});
  EXPECT_THAT(through_, SizeIs(2));
  pass(milliseconds{5000});
  EXPECT_THAT(through_, SizeIs(2));
}

TEST_F(LimiterOfFaultEvents, HasASeparateLimitForEachModuleFaultKindErrorAndOrigin) {
  put("servo", FaultKind::overrun);
  put("arm", FaultKind::overrun);
  put("servo", FaultKind::stale_input, 1, {}, "target");
  put("servo", FaultKind::stale_input, 1, {}, "limit");
  filter_.put({.module = "servo", .kind = FaultKind::error, .error = "budget"}, now_);
  filter_.put({.module = "servo", .kind = FaultKind::error, .error = "crash"}, now_);
  EXPECT_THAT(through_, SizeIs(6));
}

TEST_F(LimiterOfFaultEvents, NeverLimitsCommandsDeploymentsAndRestarts) {
  for (const FaultKind kind : {FaultKind::host_restart, FaultKind::command, FaultKind::deployed,
                               FaultKind::undeployed, FaultKind::given_up, FaultKind::node_restart}) {
    through_.clear();
    for (int i = 0; i < 10; ++i) put("servo", kind);
    EXPECT_THAT(through_, SizeIs(10)) << to_text(kind);
  }
}

TEST_F(LimiterOfFaultEvents, LimitsItsMemoryIfEventsHaveManyOrigins) {
  for (int i = 0; i < 10'000; ++i) put("", FaultKind::refused_command, 1, "no", std::to_string(i));
  EXPECT_LE(through_.size(), FaultRateLimiter::kMost + 1);
  filter_.flush();
  EXPECT_EQ(sum(), 10'000U);
}

TEST_F(LimiterOfFaultEvents, KeepsExactCountsForAnyOrderOfEvents) {
  std::mt19937 random{7};
  const std::vector<std::string> modules{"servo", "arm", "belt"};
  std::map<std::pair<std::string, FaultKind>, std::uint64_t> counters;
  for (int i = 0; i < 20'000; ++i) {
    const std::string& module = modules[random() % modules.size()];
    const FaultKind kind = random() % 2 == 0 ? FaultKind::overrun : FaultKind::missed_rows;
    const std::uint64_t count = random() % 50 + 1;
    counters[{module, kind}] += count;
    put(module, kind, count);
    pass(milliseconds{random() % 20});
  }
  filter_.flush();
  for (const Fault& fault : through_) counters[{fault.module, fault.kind}] -= fault.count;
  for (const auto& [key, left] : counters) EXPECT_EQ(left, 0U) << key.first;
  EXPECT_LT(through_.size(), 6U * 210U) << "in about 190 s";
}

}  // namespace
}  // namespace takt::agent::fault_rate_limiter_test
