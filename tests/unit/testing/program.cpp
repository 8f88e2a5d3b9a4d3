// A program for the tests of the test harness. The first argument can select a fault of the program.
#include <takt/process.hpp>

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <basic.hpp>

namespace {
takt::InPort<basic::Number> in{"in"};
takt::OutPort<basic::Count> out{"out"};
int lives = 0;  // how often main() has started with this copy of the program's variables
struct Kept {
  std::int64_t bodies = 0;
};
takt::Saved<Kept> kept{1};

void write_event(std::int64_t what) {
  basic::Count count;
  count.value(what);
  out.write(count);
}
void at_end() { write_event(-1); }
}  // namespace

int main(int argc, char* argv[]) {
  const std::string_view how = argc > 1 ? std::string_view{argv[1]} : "";
  // The program never frees this memory, because waitPeriod() does not return when the program ends.
  std::vector<int> many(1000, ++lives);
  if (how == "how=return") return 3;
  if (how == "how=exit") {
    std::fprintf(stderr, "property 'how' cannot be 'exit'\n");
    std::exit(1);
  }
  if (how == "how=throw") throw std::runtime_error("no file");
  if (how == "how=wait") waitPeriod();
  if (how == "how=sporadic") initSporadicExe();
  takt::OutPort<basic::Number> late{"late"};
  initPeriodExe();
  if (how == "how=twice") initPeriodExe();
  if (how == "how=wrong_wait") waitSporadic();
  std::optional<takt::InPort<basic::Number>> later;
  if (how == "how=late_port") later.emplace("later");
  std::atexit(at_end);
  const bool exits_at_first = how == "how=attached";
  if (exits_at_first) std::exit(4);
  while (true) {
    waitPeriod();
    ++kept->bodies;
    if (how == "how=logs") takt::log().error("body {}", kept->bodies);
    if (how == "how=saves") {
      write_event(kept->bodies * 10 + (kept.restored() ? 1 : 0));
      continue;
    }
    try {
      if (in.read() && in.value().value() < 0) throw std::runtime_error("negative");
    } catch (const std::exception&) {
      if (how == "how=waits_in_catch")
        waitPeriod();
      else
        std::exit(5);
    }
    if (in.value().value() > 2500) return 0;
    if (in.value().value() > 1000) return 6;
    write_event(static_cast<std::int64_t>(in.value().value()) +
                static_cast<std::int64_t>(takt_cycle()) * 100 + takt_period_ns() * 100'000 +
                many.front() * 10);
  }
}
