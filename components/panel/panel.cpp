// A process module in C++: the operator's panel of a station. Says how fast the belt is to run and shows what
// goes on.
#include <takt/process.hpp>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include <line.hpp>
#include <motion.hpp>

#include "../common/argument.h"

namespace {

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

void show(std::chrono::duration<double> every) {
  while (true) {
    std::this_thread::sleep_for(every);
    if (!shown.any) continue;
    std::printf("belt %s at %.2f m/s, %u parts, %.1f a minute; axis 1 at %.2f rad%s\n", word(shown.mode),
                shown.speed.load(), shown.parts.load(), shown.per_minute.load(), shown.axis.load(),
                shown.heard ? "" : " (nothing heard of the line)");
  }
}

}  // namespace

int main(int argc, char* argv[]) {
  const double speed = argument_number(argc, argv, "speed", 0.3, 0, 2);    // m/s
  const double every = argument_number(argc, argv, "show", 1, 0.1, 3600);  // s
  line::BeltCommand order;
  order.speed(speed);

  std::thread{show, std::chrono::duration<double>{every}}.detach();  // until the program ends
  initPeriodExe();
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
