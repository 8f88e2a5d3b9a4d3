// A correct periodic module that checks its grid: release n is due at T0 + n x period. At the end it writes
// "T0 RUNS STRAYED" to `file`: T0 in ns (the time of its first release), the number of its runs, and the
// number of releases off that grid.
#include <takt/component.hpp>

#include <fstream>

class Grid : public takt::Component {
  takt::Property<std::string> file{*this, "file", "", {.text = "Where the result goes at the end."}};
  std::int64_t t0_ = 0;
  std::uint64_t last_ = 0;
  long long runs_ = 0;
  long long strayed_ = 0;

  void run(const takt::Cycle& cycle) noexcept override {
    const std::int64_t t0 =
        takt::to_ns(cycle.time) - static_cast<std::int64_t>(cycle.number) * cycle.period.count();
    if (runs_++ == 0) {
      t0_ = t0;
    } else if (t0 != t0_ || cycle.number <= last_) {
      ++strayed_;
    }
    last_ = cycle.number;
  }
  void destruct() override {
    if (!file.value().empty()) std::ofstream(file.value()) << t0_ << ' ' << runs_ << ' ' << strayed_ << '\n';
  }
};
TAKT_COMPONENT(Grid)
