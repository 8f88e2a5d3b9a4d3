// A periodic process module that uses SafeWatch to report the samples and safe values that it reads.
#include <takt/process.hpp>

#include <string>

#include "safe_value.hpp"

namespace {
takt::InPort<samples::Count> in{"in"};
takt::Property<std::string> who{"who", "program"};
takt::Property<std::int64_t> oldest{"oldest", 0, {.unit = "ns", .min = 0, .text = "Of a sample; 0: of any age."}};
}  // namespace

int main() {
  SafeWatch watch{std::chrono::nanoseconds{oldest}};
  const std::string name = who.value();
  initPeriodExe();
  while (true) {
    waitPeriod();
    const bool news = in.read();
    if (in.has_value()) watch.look(name.c_str(), in, news);
  }
}
