// A process module in C++: the operator's panel of a station. Says how fast the belt is to run and shows what
// goes on.
#include <takt/process.hpp>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <line.hpp>
#include <motion.hpp>

#include "../common/argument.h"

namespace {

takt::OutPort<line::BeltCommand> command{"command"};
takt::InPort<line::BeltState> belt{"belt"};
takt::InPort<motion::JointState> arm{"arm"};
takt::InPort<line::Throughput> throughput{"throughput"};

const char* word(line::BeltMode mode) {
  return mode == line::BELT_RUNNING ? "running" : mode == line::BELT_HOLDING ? "holding a part" : "stopped";
}

}  // namespace

int main(int argc, char* argv[]) {
  const double speed = argument_number(argc, argv, "speed", 0.3, 0, 2);    // m/s
  const double every = argument_number(argc, argv, "show", 1, 0.1, 3600);  // s
  line::BeltCommand order;
  order.speed(speed);

  initPeriodExe();
  double since = 0;
  while (true) {
    waitPeriod();
    command.write(order);
    belt.read();
    arm.read();
    throughput.read();
    since += static_cast<double>(takt_period_ns()) * 1e-9;
    if (since < every - 1e-6) continue;
    since = 0;
    std::printf("belt %s at %.2f m/s, %u parts, %.1f a minute; axis 1 at %.2f rad%s\n",
                word(belt.value().mode()), belt.value().speed(), belt.value().parts(),
                throughput.value().per_minute(), arm.value().position()[0],
                belt.connected() && belt.has_value() ? "" : " (nothing heard of the line)");
  }
}
