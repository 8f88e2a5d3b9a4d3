#include <takt/node/flow_manager.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include <long_enough.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/shared.hpp>
#include <takt/os/clock.hpp>

namespace takt::node::flow_manager_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

/// The instructions of a test to a SlowGateway, and what the gateway has done.
class Steps {
 public:
  /// Lets the gateway finish this many more calls.
  void let(int calls) {
    const std::lock_guard lock{mutex_};
    allowed_ += calls;
    changed_.notify_all();
  }
  /// Waits until the test lets one more call finish. Returns false if the test has not done so in time.
  bool wait() {
    std::unique_lock lock{mutex_};
    const bool let = changed_.wait_for(lock, long_enough(), [this] { return allowed_ > 0; });
    --allowed_;
    return let;
  }

  void thin_out(Nanoseconds every) {
    const std::lock_guard lock{mutex_};
    thinned_.push_back(every);
  }
  [[nodiscard]] std::vector<Nanoseconds> thinned() {
    const std::lock_guard lock{mutex_};
    return thinned_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int allowed_ = 0;
  std::vector<Nanoseconds> thinned_;
};

/// A gateway in which each flow is added and removed only when the test lets it happen.
class SlowGateway final : public dds::Gateway {
 public:
  explicit SlowGateway(Steps& steps, bool rejects = false) : steps_(steps), rejects_(rejects) {}
  Result<FlowId> add_outgoing(const dds::Flow&, channel::Link) override { return add(); }
  Result<FlowId> add_incoming(const dds::Flow&, std::vector<channel::Link>) override { return add(); }
  void thin_out(FlowId, Nanoseconds every) override { steps_.thin_out(every); }
  void remove(FlowId) override { EXPECT_TRUE(steps_.wait()) << "the caller waits for the removal"; }
  [[nodiscard]] wire::FlowHealth health(FlowId flow) const override {
    wire::FlowHealth health;
    health.matched = static_cast<std::uint32_t>(flow);
    return health;
  }

 private:
  Result<FlowId> add() {
    EXPECT_TRUE(steps_.wait()) << "the caller waits for the new flow";
    if (rejects_) return fail("DDS rejects the flow");
    return ++last_;
  }
  Steps& steps_;
  const bool rejects_;
  FlowId last_ = 0;
};

/// The wiring of device "here": input `in` is connected to a device "there", output `out` has no connection.
class Flows : public testing::Test {
 protected:
  Flows() {
    cell_.name = "cell";
    cell_.devices = {{.name = "here", .executors = {{}}, .modules = {}},
                     {.name = "there", .executors = {{}}, .modules = {}}};
    model::Module module;
    module.name = "a";
    cell_.devices[0].modules.push_back(module);
    const model::Type type{"t::T", {{.name = "x", .scalar = model::Scalar::float64}}};
    const std::vector<model::ModulePorts> ports{model::ModulePorts{
        {{"in", model::Direction::in, type, "", false}, {"out", model::Direction::out, type, "", false}}}};
    model::Connection& connection = cell_.connections.emplace_back();
    connection.from = {"there", "b", "out"};
    connection.to = {"here", "a", "in"};
    auto wiring = supervision::Wiring::create(supervision::plan_wiring(cell_, 0, ports));
    EXPECT_TRUE(wiring.ok());
    wiring_.emplace(std::move(*wiring));
    auto wake_word = channel::Shared<channel::WakeWord>::create("wake word");
    EXPECT_TRUE(wake_word.ok());
    wake_word_ = std::move(*wake_word);
  }

  std::unique_ptr<FlowManager> open(bool rejects = false) {
    auto opened = FlowManager::open(std::make_unique<SlowGateway>(steps_, rejects), wake_word_.memory(),
                                    *wiring_, cell_, "here");
    EXPECT_TRUE(opened.ok());
    return opened ? std::move(*opened) : nullptr;
  }
  /// The index of the only link of this port.
  std::size_t link_of(const std::string& port) const {
    for (std::size_t i = 0; i < wiring_->links().size(); ++i) {
      const supervision::PlannedLink& plan = wiring_->links()[i].plan;
      if (plan.from.port == port || plan.to.port == port) return i;
    }
    ADD_FAILURE() << "no link of " << port;
    return 0;
  }
  bool enabled(const std::string& port) const {
    return wiring_->links()[link_of(port)].link.block().enabled.load() != 0;
  }
  template <class Holds>
  static bool soon(Holds&& holds) {
    const auto end = std::chrono::steady_clock::now() + long_enough();
    while (!holds() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(1ms);
    return holds();
  }

  model::Cell cell_;
  std::optional<supervision::Wiring> wiring_;
  channel::Shared<channel::WakeWord> wake_word_;
  Steps steps_;
};

TEST_F(Flows, OpenWhileTheCallerContinues) {
  const auto flows = open();
  EXPECT_FALSE(flows->opened().has_value());
  EXPECT_FALSE(flows->health(link_of("in")).has_value());
  steps_.let(1);
  ASSERT_TRUE(soon([&] { return flows->opened().has_value(); }));
  EXPECT_TRUE(flows->opened()->ok());
  EXPECT_EQ(flows->health(link_of("in")).value_or(wire::FlowHealth{}).matched, 1U);
  EXPECT_FALSE(flows->health(link_of("out")).has_value()) << "it has no connection";
}

TEST_F(Flows, NameTheTopicOfAFlowThatCannotBeOpened) {
  const auto flows = open(true);
  steps_.let(1);
  ASSERT_TRUE(soon([&] { return flows->opened().has_value(); }));
  EXPECT_THAT(to_text(flows->opened()->problems()),
              HasSubstr("topic takt/cell/there/b/out: DDS rejects the flow"));
}

TEST_F(Flows, OpenAndCloseForAnObserverWhileTheCallerContinues) {
  const auto flows = open();
  const Instant now = os::now();
  ASSERT_TRUE(flows->tap(0, "out", now + 1s, 0s).ok());
  EXPECT_FALSE(flows->health(link_of("out")).has_value());
  steps_.let(1);
  ASSERT_TRUE(soon([&] { return enabled("out"); })) << "before the flow is open, so that no reply is lost";
  EXPECT_FALSE(flows->health(link_of("out")).has_value());
  steps_.let(1);
  EXPECT_TRUE(soon([&] { return flows->health(link_of("out")).has_value(); }));

  flows->step(now + 2s);
  EXPECT_TRUE(enabled("out")) << "the gateway still reads the link";
  EXPECT_FALSE(flows->health(link_of("out")).has_value());
  ASSERT_TRUE(flows->tap(0, "out", now + 3s, 0s).ok()) << "another observer comes while the flow closes";
  steps_.let(2);
  EXPECT_TRUE(soon([&] {
    const auto health = flows->health(link_of("out"));
    return health && health->matched == 3;  // the third flow: `in` and `out` were opened before
  }));
  EXPECT_TRUE(enabled("out"));
  flows->step(now + 4s);
  steps_.let(1);
  EXPECT_TRUE(soon([&] { return !enabled("out"); }));
}

TEST_F(Flows, CarryEverySampleOnlyWhileAnObserverWantsThem) {
  const auto flows = open();
  const Instant now = os::now();
  steps_.let(3);
  ASSERT_TRUE(flows->tap(0, "out", now + 9s, 200ms).ok());
  ASSERT_TRUE(flows->tap(0, "out", now + 2s, 0s).ok()) << "a recorder wants every sample";
  ASSERT_TRUE(flows->tap(0, "out", now + 9s, 100ms).ok());
  flows->step(now + 1s);
  flows->step(now + 3s);
  EXPECT_TRUE(soon([&] { return steps_.thinned() == std::vector<Nanoseconds>{200ms, 0ms, 0ms, 100ms}; }));
}

}  // namespace
}  // namespace takt::node::flow_manager_test
