// Reads all new samples in each run, and writes a summary to `file` at the end.
#include <takt/component.hpp>

#include <string>

#include "seen_file.hpp"

class PortSink : public takt::Component {
  takt::InPort<samples::Count> in{*this, "in"};
  takt::Property<std::string> file{*this, "file", ""};
  takt::Property<std::int64_t> most{*this, "most", 1000, {.min = 0, .text = "Samples read in one run()."}};

  Seen seen_;

  void run(const takt::Cycle&) noexcept override {
    for (std::int64_t i = 0; i < most && in.read(); ++i) seen_.take(in.value(), in.age().count());
  }
  void destruct() override { write_seen(file, seen_); }
};
TAKT_COMPONENT(PortSink)
