#include <takt/node/flight_recorder.hpp>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>

namespace takt::node::flight_recorder_test {
namespace {

using namespace std::chrono_literals;

// The thread that writes traces shares locks with the node's main thread, such as the locks of the heap. If
// this thread held a lock at a low priority, other threads could preempt it, and the main thread would wait
// for the lock.
TEST(FlightRecorder, WritesTracesOnAThreadWithTheSamePriorityAsTheNode) {
  model::Device device;
  device.executors.emplace_back();
  const auto plan = schedule::plan(model::Cell{}, device);
  const auto channel = channel::Channel::create(1, {"main"}, {});
  ASSERT_TRUE(plan && channel);
  auto recorder = FlightRecorder::create(
      {.cell = "cell", .device = "robot", .modules = {}, .executors = {"main"}, .files = {}}, *plan,
      *channel);
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

// The names of traces contain their time. So if the clock was set back, older traces have names with later
// times.
TEST(FlightRecorder, KeepsANewTraceEvenIfOlderTracesHaveLaterTimes) {
  namespace fs = std::filesystem;
  const fs::path folder = testing::TempDir() + "takt-traces-" + std::to_string(os::process_id());
  fs::create_directories(folder);
  for (int i = 0; i < 8; ++i)
    std::ofstream{folder / ("robot.0.2999010" + std::to_string(i) + "T000000.000Z.trace.json")} << "{}";
  model::Device device;
  device.executors.emplace_back();
  const auto plan = schedule::plan(model::Cell{}, device);
  const auto channel = channel::Channel::create(1, {"main"}, {});
  ASSERT_TRUE(plan && channel);
  {
    auto recorder = FlightRecorder::create({.cell = "cell",
                                            .device = "robot",
                                            .modules = {},
                                            .executors = {"main"},
                                            .files = folder / "robot.0"},
                                           *plan, *channel);
    ASSERT_TRUE(recorder);
    (*recorder)->fault("something");
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator{folder}) names.push_back(entry.path().filename());
  fs::remove_all(folder);
  std::sort(names.begin(), names.end());
  ASSERT_EQ(names.size(), 8U);
  EXPECT_LT(names[0], "robot.0.2999") << "the new trace is kept";
  EXPECT_EQ(names[1].substr(0, 16), "robot.0.29990101") << "the oldest trace is removed";
}

TEST(FlightRecorder, WritesTheTraceOfACrashSoonAfterATraceOfMissedRows) {
  namespace fs = std::filesystem;
  const fs::path folder = testing::TempDir() + "takt-traces-" + std::to_string(os::process_id());
  fs::create_directories(folder);
  model::Device device;
  device.executors.emplace_back();
  const auto plan = schedule::plan(model::Cell{}, device);
  const auto channel = channel::Channel::create(1, {"main"}, {});
  ASSERT_TRUE(plan && channel);
  auto recorder = FlightRecorder::create(
      {.cell = "cell", .device = "robot", .modules = {}, .executors = {"main"}, .files = folder / "robot.0"},
      *plan, *channel);
  ASSERT_TRUE(recorder);
  const Instant begin = os::now();
  channel->executor(0).missed.store(5);
  (*recorder)->step(begin);
  (*recorder)->step(begin + 1s);  // the time to write the trace of the missed rows
  (*recorder)->fault("the host was killed by SIGSEGV");
  std::size_t written = 0;
  for (const Instant end = os::now() + 10s; written < 2 && os::now() < end;
       std::this_thread::sleep_for(1ms)) {
    (*recorder)->step(begin + 2s);
    written += (*recorder)->messages().size();
  }
  EXPECT_EQ(written, 2U);
  recorder->reset();
  fs::remove_all(folder);
}

}  // namespace
}  // namespace takt::node::flight_recorder_test
