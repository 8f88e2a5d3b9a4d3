// A module that counts its runs in a saved value, and prints in start() what it restored. Each instance
// crashes in its `after`-th run. `keeps.so` saves version 1 of the value. `keeps_more.so`, from the same
// source, saves version 2, and can restore version 1.
#include <takt/component.hpp>

#include <cstdio>
#include <cstring>

#ifdef KEEPS_MORE
struct Kept {
  std::uint64_t instances = 0;
  std::uint64_t runs = 0;
};
constexpr std::uint32_t kVersion = 2;
#else
struct Kept {
  std::uint64_t runs = 0;
};
constexpr std::uint32_t kVersion = 1;
#endif

class Keeps : public takt::Component {
  takt::Saved<Kept> kept_{*this, kVersion};
  takt::Property<std::int64_t> after{*this, "after", 1'000'000'000};
  std::int64_t runs_ = 0;
  volatile int* volatile nowhere_ = nullptr;

#ifdef KEEPS_MORE
  takt::Result<void> restore(const takt::SavedBefore& before) override {
    if (before.version != 1 || before.size != sizeof(std::uint64_t))
      return takt::fail("only version 1 is known");
    std::memcpy(&kept_->runs, before.data, sizeof kept_->runs);
    return {};
  }
#endif
  takt::Result<void> start() override {
    std::printf("version %u %s %llu\n", kVersion, kept_.restored() ? "restored" : "began",
                static_cast<unsigned long long>(kept_->runs));
    return {};
  }
  void run(const takt::Cycle&) noexcept override {
    ++kept_->runs;
    if (++runs_ == after) *nowhere_ = 1;
  }
};
TAKT_COMPONENT(Keeps)
