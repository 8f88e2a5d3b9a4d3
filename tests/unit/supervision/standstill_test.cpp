// Tests that a program is not killed as hanging because the machine stood still.
#include <takt/supervision/supervisor.hpp>

#include <memory>

#include <gmock/gmock.h>

#include "fake_platform.hpp"

namespace takt::supervision::standstill_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A device with a program whose hang limit is 3 s, and whose body has just begun.
class Standstill : public testing::Test {
 protected:
  Standstill() {
    module_.name = "p";
    module_.type = model::ModuleType::process;
    module_.executor = "main";
    module_.period = milliseconds{10};
    module_.hang = seconds{3};
    cell_.name = "c";
    cell_.devices = {{.name = "d", .executors = {{}}, .modules = {module_}}};
    device_ = std::make_unique<Supervisor>(
        Supervisor::Options{.cell = cell_, .paths = {"p"}, .ports = {std::nullopt}}, platform_);
    EXPECT_TRUE(device_->prepare().ok());
    slot().phase = channel::ReleaseSlotPhase::ready;
    pass(milliseconds{5}, 3);
    EXPECT_EQ(device_->machine(0).state(), lifecycle::State::start);
    slot().release_ns = to_ns(platform_->time);
    slot().released = 1;
  }
  channel::ReleaseSlot& slot() { return *platform_->memory->slot_of(0); }
  void pass(Nanoseconds each, int steps) {
    for (int i = 0; i < steps; ++i) {
      platform_->time += each;
      device_->step();
    }
  }
  [[nodiscard]] int kills() const { return platform_->kills; }

 private:
  model::Module module_;
  model::Cell cell_;
  const std::shared_ptr<FakePlatform> platform_ = std::make_shared<FakePlatform>();
  std::unique_ptr<Supervisor> device_;
};

TEST_F(Standstill, KillsAProgramAtItsHangLimit) {
  pass(milliseconds{10}, 299);
  EXPECT_EQ(kills(), 0);
  pass(milliseconds{10}, 1);
  EXPECT_EQ(kills(), 1);
}

TEST_F(Standstill, DoesNotKillAProgramBecauseOfAPauseOfTheMachine) {
  pass(milliseconds{10}, 200);
  pass(seconds{8}, 1);
  pass(milliseconds{10}, 299);
  EXPECT_EQ(kills(), 0) << "after the pause, the program has its full time";
  pass(milliseconds{10}, 1);
  EXPECT_EQ(kills(), 1);
}

TEST_F(Standstill, CountsAShortPauseForAtMostAQuarterOfTheHangLimit) {
  pass(milliseconds{1500}, 2);
  EXPECT_EQ(kills(), 0);
}

TEST_F(Standstill, KillsAProgramIfTheNodeRarelyHasTheCpu) {
  for (int i = 0; i < 4; ++i) {
    pass(milliseconds{950}, 1);
    pass(milliseconds{10}, 5);
  }
  EXPECT_EQ(kills(), 1);
}

}  // namespace
}  // namespace takt::supervision::standstill_test
