#include <takt/node/flight_recorder.hpp>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <string>
#include <thread>

#include <takt/os/clock.hpp>

namespace takt::node {
namespace {

using namespace std::chrono_literals;

// It shares locks with the node's thread, those of the heap among them. One that a thread in the background
// holds is waited for as long as others keep the processors.
TEST(FlightRecorder, MakesTracesOnAThreadThatIsAsUrgentAsTheNode) {
  model::Device device;
  device.executors.emplace_back();
  const auto plan = schedule::plan(model::Cell{}, device);
  const auto channel = channel::Channel::create(1, {"main"}, {});
  ASSERT_TRUE(plan && channel);
  auto recorder = FlightRecorder::create(
      {.cell = "cell", .device = "robot", .modules = {}, .executors = {"main"}, .files = {}}, *plan, *channel);
  ASSERT_TRUE(recorder);
  bool done = false;
  (*recorder)->trace(1s, 1 << 20, [&done](const Result<std::string>& text) { done = text.ok(); });
  for (const Instant end = os::now() + 10s; !done && os::now() < end; std::this_thread::sleep_for(1ms))
    (*recorder)->step(os::now());
  ASSERT_TRUE(done);
  for (const auto& task : std::filesystem::directory_iterator{"/proc/self/task"}) {
    const auto thread = static_cast<id_t>(std::stoi(task.path().filename().string()));
    EXPECT_EQ(::getpriority(PRIO_PROCESS, thread), ::getpriority(PRIO_PROCESS, 0)) << thread;
  }
}

}  // namespace
}  // namespace takt::node
