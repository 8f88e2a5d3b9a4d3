// A process module in C++: the operator's panel of a station. Says how fast the belt is to run and shows what
// goes on.
#include <takt/process.hpp>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include <line.hpp>
#include <motion.hpp>

TAKT_TEXT("Operator's panel without a screen: says how fast the belt runs, and prints what goes on.");

namespace {

takt::Property<double> speed{"speed", 0.3, {.unit = "m/s", .min = 0, .max = 2, .text = "Of the belt."}};
takt::Property<double> every{"show", 1, {.unit = "s", .min = 0.1, .max = 3600, .text = "Between two lines."}};

takt::OutPort<line::BeltCommand> command{"command"};
takt::InPort<line::BeltState> belt{"belt"};
takt::InPort<motion::JointState> arm{"arm"};
takt::InPort<line::Throughput> throughput{"throughput"};

/// What is shown, left by the body for the thread that prints: the body is released on time, and printing
/// waits for whoever reads. Each value is whole by itself, which is enough for a display.
struct Shown {
  std::atomic<bool> any{false};
  std::atomic<bool> heard{false};
  std::atomic<line::BeltMode> mode{};
  std::atomic<double> speed{0};
  std::atomic<std::uint32_t> parts{0};
  std::atomic<double> per_minute{0};
  std::atomic<double> axis{0};
};
Shown shown;

const char* word(line::BeltMode mode) {
  return mode == line::BELT_RUNNING ? "running" : mode == line::BELT_HOLDING ? "holding a part" : "stopped";
}

void show(std::chrono::duration<double> pause) {
  while (true) {
    std::this_thread::sleep_for(pause);
    if (!shown.any) continue;
    std::printf("belt %s at %.2f m/s, %u parts, %.1f a minute; axis 1 at %.2f rad%s\n", word(shown.mode),
                shown.speed.load(), shown.parts.load(), shown.per_minute.load(), shown.axis.load(),
                shown.heard ? "" : " (nothing heard of the line)");
  }
}

}  // namespace

int main() {
  initPeriodExe();
  line::BeltCommand order;
  order.speed(speed);

  std::thread{show, std::chrono::duration<double>{every}}.detach();  // until the program ends
  while (true) {
    waitPeriod();
    command.write(order);
    belt.read();
    arm.read();
    throughput.read();
    shown.heard = belt.connected() && belt.has_value();
    shown.mode = belt.value().mode();
    shown.speed = belt.value().speed();
    shown.parts = belt.value().parts();
    shown.per_minute = throughput.value().per_minute();
    shown.axis = arm.value().position()[0];
    shown.any = true;
  }
}
