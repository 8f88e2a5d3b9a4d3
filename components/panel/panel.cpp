// A process module in C++: the operator's panel of a station. The panel sets the belt speed, prints the state
// of the cell, counts the placed parts, and predicts their number from the timing of the cell.
#include <takt/process.hpp>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>

#include <basic.hpp>
#include <line.hpp>
#include <motion.hpp>

#include "expected.hpp"

TAKT_TEXT("Operator's panel without a screen: sets the belt speed, prints the cell's state, counts parts.");

namespace {

takt::Property<double> speed{
    "speed", 0.3, {.unit = "m/s", .min = 0, .max = 2, .text = "Wanted speed of the belt."}};
takt::Property<double> every{
    "show", 1, {.unit = "s", .min = 0.1, .max = 3600, .text = "Time between two printed lines."}};
takt::Property<double> bring{
    "bring",
    0,
    {.unit = "s",
     .min = 0,
     .max = 3600,
     .text =
         "Expected time from placing a part to the next pick request; 0: no prediction of placed parts."}};

takt::OutPort<line::BeltCommand> command{"command", {.text = "Wanted speed of the belt."}};
takt::OutPort<basic::Number> placed{"placed", {.text = "Number of placed parts, for a display."}};
takt::InPort<line::BeltState> belt{"belt", {.text = "State of the belt."}};
takt::InPort<motion::JointState> arm{"arm", {.text = "Position of the axes."}};
takt::InPort<line::Throughput> throughput{"throughput", {.text = "Parts per minute."}};
takt::InPort<motion::PickPlan> plan{"plan",
                                    {.text = "Time that the arm needs for a part; connect it as a queue."}};
takt::InPort<motion::PickDone> done{"done", {.text = "Result of a pick request; connect it as a queue."}};
takt::InPort<basic::Flag> run_permitted{"run_permitted",
                                        {.text = "False: emergency stop. Always true if not connected."}};

/// The values to print. The real-time body passes them to a separate thread, because printing may block. Two
/// values may come from different periods, which is good enough for a display.
struct Shown {
  std::atomic<bool> any{false};
  std::atomic<bool> has_belt{false};
  std::atomic<bool> permitted{true};
  std::atomic<line::BeltMode> mode{};
  std::atomic<double> speed{0};
  std::atomic<double> per_minute{0};
  std::atomic<double> axis{0};
  std::atomic<std::uint32_t> placed{0};
  std::atomic<std::uint32_t> failed{0};
};
Shown shown;
panel::Expected expected;

const char* word(line::BeltMode mode) {
  return mode == line::BELT_RUNNING ? "running" : mode == line::BELT_HOLDING ? "holding a part" : "stopped";
}

void show(std::chrono::duration<double> pause) {
  while (true) {
    std::this_thread::sleep_for(pause);
    if (!shown.any) continue;
    std::printf("%sbelt %s at %.2f m/s, %.1f parts per minute, %u placed; axis 1 at %.2f rad%s\n",
                shown.permitted ? "" : "EMERGENCY STOP; ", word(shown.mode), shown.speed.load(),
                shown.per_minute.load(), shown.placed.load(), shown.axis.load(),
                shown.has_belt ? "" : " (no data from the line)");
  }
}

/// Prints a summary when the process ends.
void print_summary() {
  std::printf("parts placed: %u", shown.placed.load());
  if (expected.part_time() > 0) {
    std::printf("; predicted from the timing: %u, one every %.2f s (the arm takes %.2f s), in %.1f s",
                expected.parts(), expected.part_time(), expected.arm_time(), expected.running());
    if (expected.stopped() > 0) std::printf(" plus %.1f s of emergency stop", expected.stopped());
  }
  if (shown.failed > 0) std::printf("; %u rejected or lost", shown.failed.load());
  std::printf("\n");
}

}  // namespace

int main() {
  initPeriodExe();
  expected.bring(bring);
  line::BeltCommand belt_command;
  belt_command.speed(speed);
  basic::Number count;
  std::uint32_t last_done = 0;

  std::atexit(print_summary);
  // This thread runs until the process ends.
  std::thread{show, std::chrono::duration<double>{every}}.detach();
  while (true) {
    waitPeriod();
    command.write(belt_command);
    belt.read();
    arm.read();
    throughput.read();
    run_permitted.read();
    while (plan.read()) {
      const motion::PickPlan& announced = plan.value();
      expected.planned(
          {.number = announced.number(), .placed = announced.placed(), .ended = announced.ended()});
    }
    while (done.read()) {
      // Count each part once. The arm reports a part twice if it was requested twice.
      if (std::exchange(last_done, done.value().number()) == done.value().number()) continue;
      ++(done.value().result() == motion::PICK_PLACED ? shown.placed : shown.failed);
    }
    shown.has_belt = belt.connected() && belt.has_value();
    shown.permitted =
        !run_permitted.connected() || (run_permitted.has_value() && run_permitted.value().value());
    if (shown.has_belt) expected.pass(static_cast<double>(takt_period_ns()) * 1e-9, shown.permitted);
    count.value(shown.placed);
    placed.write(count);
    shown.mode = belt.value().mode();
    shown.speed = belt.value().speed();
    shown.per_minute = throughput.value().per_minute();
    shown.axis = arm.value().position()[0];
    shown.any = true;
  }
}
