// A periodic thread module for `takt bench`. If its property `file` is set, it writes its jitter to this
// file.
#include <takt/component.hpp>

#include "filter_step.hpp"
#include "recording.hpp"

class BenchPeriodic : public takt::Component {
  takt::Property<std::string> file{
      *this,
      "file",
      "",
      {.text = "The file to which the module writes its jitter at the end; if empty, it writes none."}};
  takt::Property<std::int64_t> releases{
      *this,
      "releases",
      0,
      {.min = 0, .max = 1'000'000'000, .text = "The maximum number of recorded releases."}};

  takt::bench::Recording jitter_;
  takt::bench::Work work_;

  takt::Result<void> initialize() override {
    jitter_.reserve(static_cast<std::size_t>(releases.value()));
    return {};
  }
  void run(const takt::Cycle& cycle) noexcept override {
    jitter_.note(static_cast<std::int64_t>(cycle.number), (cycle.time - cycle.start).count());
    work_.step();
  }
  void destruct() override {
    if (!file.value().empty()) static_cast<void>(jitter_.write(file));
  }
};
TAKT_COMPONENT(BenchPeriodic)
