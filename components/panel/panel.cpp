// A process module in C++: the operator's panel of a station. Says how fast the belt is to run, shows what
// goes on, and counts the parts that were placed beside those that the cell's timing lets expect.
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

TAKT_TEXT(
    "Operator's panel without a screen: says how fast the belt runs, prints what goes on, counts parts.");

namespace {

takt::Property<double> speed{"speed", 0.3, {.unit = "m/s", .min = 0, .max = 2, .text = "Of the belt."}};
takt::Property<double> every{"show", 1, {.unit = "s", .min = 0.1, .max = 3600, .text = "Between two lines."}};
takt::Property<double> bring{"bring",
                             0,
                             {.unit = "s",
                              .min = 0,
                              .max = 3600,
                              .text = "From a part's being placed to the next one's being asked for."}};

takt::OutPort<line::BeltCommand> command{"command", {.text = "How fast the belt is to run."}};
takt::OutPort<basic::Number> placed{"placed", {.text = "Parts that were placed, for a display."}};
takt::InPort<line::BeltState> belt{"belt", {.text = "What the belt does."}};
takt::InPort<motion::JointState> arm{"arm", {.text = "Where the axes are."}};
takt::InPort<line::Throughput> throughput{"throughput", {.text = "Parts in a minute."}};
takt::InPort<motion::PickPlan> plan{"plan", {.text = "How long the arm takes for the part."}};
takt::InPort<motion::PickDone> done{"done", {.text = "What became of a part."}};
takt::InPort<basic::Flag> run_permitted{"run_permitted",
                                        {.text = "No emergency stop. Not connected: always."}};

/// What is shown, left by the body for the thread that prints: the body is released on time, and printing
/// waits for whoever reads. Each value is whole by itself, which is enough for a display.
struct Shown {
  std::atomic<bool> any{false};
  std::atomic<bool> heard{false};
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
    std::printf("%sbelt %s at %.2f m/s, %.1f parts a minute, %u placed; axis 1 at %.2f rad%s\n",
                shown.permitted ? "" : "EMERGENCY STOP; ", word(shown.mode), shown.speed.load(),
                shown.per_minute.load(), shown.placed.load(), shown.axis.load(),
                shown.heard ? "" : " (nothing heard of the line)");
  }
}

/// Of the whole time; the body runs no more then.
void say_goodbye() {
  std::printf("parts placed: %u", shown.placed.load());
  if (expected.part_time() > 0) {
    std::printf("; its timing predicts %u: one every %.2f s, of which the arm takes %.2f s, in %.1f s",
                expected.parts(), expected.part_time(), expected.arm_time(), expected.running());
    if (expected.stopped() > 0) std::printf(" beside %.1f s of emergency stop", expected.stopped());
  }
  if (shown.failed > 0) std::printf("; %u refused or lost", shown.failed.load());
  std::printf("\n");
}

}  // namespace

int main() {
  initPeriodExe();
  expected.bring(bring);
  line::BeltCommand order;
  order.speed(speed);
  basic::Number count;
  std::uint32_t last_done = 0;

  std::atexit(say_goodbye);
  std::thread{show, std::chrono::duration<double>{every}}.detach();  // until the program ends
  while (true) {
    waitPeriod();
    command.write(order);
    belt.read();
    arm.read();
    throughput.read();
    run_permitted.read();
    while (plan.read()) {
      const motion::PickPlan& told = plan.value();
      expected.planned({.number = told.number(), .placed = told.placed(), .ended = told.ended()});
    }
    while (done.read()) {
      // A part that was asked for twice is told of twice.
      if (std::exchange(last_done, done.value().number()) == done.value().number()) continue;
      ++(done.value().result() == motion::PICK_PLACED ? shown.placed : shown.failed);
    }
    shown.heard = belt.connected() && belt.has_value();
    shown.permitted =
        !run_permitted.connected() || (run_permitted.has_value() && run_permitted.value().value());
    if (shown.heard) expected.pass(static_cast<double>(takt_period_ns()) * 1e-9, shown.permitted);
    count.value(shown.placed);
    placed.write(count);
    shown.mode = belt.value().mode();
    shown.speed = belt.value().speed();
    shown.per_minute = throughput.value().per_minute();
    shown.axis = arm.value().position()[0];
    shown.any = true;
  }
}
