// Writes samples numbered from 1. The safe value of the output has number 0, and -1 in the other fields. The
// property `how` can be set while the module runs. 1: the module writes nothing. 2: run() fails. 3: run()
// crashes. 4: one call of run() takes 50 ms.
#include <takt/component.hpp>

#include <chrono>
#include <csignal>

#include "safe_value.hpp"
#include "sample.hpp"

class SafeSource : public takt::Component {
  takt::OutPort<samples::Count> out{*this, "out", {.text = "Numbered from 1.", .safe = safe_value(0)}};
  takt::Property<std::int64_t> how{*this, "how", 0, {.min = 0, .max = 4}};

  samples::Count count_;
  std::uint64_t number_ = 0;
  bool slept_ = false;

  takt::Result<void> initialize() override {
    count_.few().reserve(4);
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    if (how == 1) return;
    if (how == 2) return fail("it was told to");
    if (how == 3) std::raise(SIGSEGV);
    if (how == 4 && !slept_) {
      slept_ = true;
      const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds{50};
      while (std::chrono::steady_clock::now() < end) {
      }
    }
    fill(count_, ++number_);
    out.write(count_);
  }
};
TAKT_COMPONENT(SafeSource)
