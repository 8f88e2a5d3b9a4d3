// A module that counts its runs in a saved value and writes the count to its output. `ticks.so` saves version
// 1 of the value, and `ticks_more.so` saves version 2. Each can restore the value of the other. A swap to any
// of the following components must fail:
//
//   ticks_fails    its third run fails        ticks_other     other ports and properties
//   ticks_crashes  its third run crashes      ticks_forgets   does not restore what version 1 saved
//   ticks_hangs    its initialize() never returns
//
// `ticks.so` crashes if its property `step` is negative, and `ticks_more.so` if it is less than -5.
#include <takt/component.hpp>

#include <cstdio>
#include <cstring>
#include <string>

#include "sample.hpp"

struct One {
  std::uint64_t count = 0;
};
struct Two {
  std::uint64_t instances = 0;
  std::uint64_t count = 0;
};

#if defined(TICKS_MORE) || defined(TICKS_FORGETS)
using Kept = Two;
constexpr std::uint32_t kVersion = 2;
#else
using Kept = One;
constexpr std::uint32_t kVersion = 1;
#endif

class Ticks : public takt::Component {
  takt::OutPort<samples::Count> out{*this, "out"};
  takt::InPort<samples::Count> in{*this, "in"};
  takt::Property<std::string> label{*this, "label", "none"};
#ifdef TICKS_OTHER
  takt::OutPort<samples::Count> more{*this, "more"};
  takt::Property<std::int64_t> step{*this, "step", 1};
#else
  takt::Property<double> step{*this, "step", 1.0};
#endif
  takt::Saved<Kept> kept_{*this, kVersion};
  samples::Count count_;
  int runs_ = 0;
  volatile int* volatile nowhere_ = nullptr;

#ifndef TICKS_FORGETS
  takt::Result<void> restore(const takt::SavedBefore& before) override {
    One one;
    Two two;
    if (before.version == 1 && before.size == sizeof one) {
      std::memcpy(&one, before.data, sizeof one);
      kept_->count = one.count;
    } else if (before.version == 2 && before.size == sizeof two) {
      std::memcpy(&two, before.data, sizeof two);
      kept_->count = two.count;
    } else {
      return takt::fail("only versions 1 and 2 are known");
    }
    return {};
  }
#endif
  takt::Result<void> initialize() override {
    count_.few().reserve(4);
#ifdef TICKS_HANGS
    while (nowhere_ == nullptr) continue;
#endif
    return {};
  }
  takt::Result<void> start() override {
    std::printf("version %u %s %llu, label %s\n", kVersion, kept_.restored() ? "from" : "begins at",
                static_cast<unsigned long long>(kept_->count), label.value().c_str());
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    ++runs_;
#ifdef TICKS_FAILS
    if (runs_ == 3) return fail("the third is not for me");
#endif
#ifdef TICKS_CRASHES
    if (runs_ == 3) *nowhere_ = 1;
#endif
    if (step < (kVersion == 1 ? 0 : -5)) *nowhere_ = 1;
    fill(count_, ++kept_->count);
    out.write(count_);
  }
};
TAKT_COMPONENT(Ticks)
