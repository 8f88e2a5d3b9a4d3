// A process module that counts the executions of its body in a saved value, and prints the value that it
// restored. Each of its processes crashes in the `after`-th execution of the body.
#include <takt/process.hpp>

#include <cstdio>

#ifdef KEEPS_MORE
struct Kept {
  std::uint64_t lives = 0;
  std::uint64_t bodies = 0;
};
constexpr std::uint32_t kVersion = 2;
#else
struct Kept {
  std::uint64_t bodies = 0;
};
constexpr std::uint32_t kVersion = 1;
#endif

takt::Saved<Kept> kept{kVersion};
takt::Property<std::int64_t> after{"after", 1'000'000'000};

int main() {
  volatile int* volatile nowhere = nullptr;
  initPeriodExe();
  std::printf("version %u %s %llu\n", kVersion, kept.restored() ? "restored" : "began",
              static_cast<unsigned long long>(kept->bodies));
  for (std::int64_t bodies = 0;;) {
    waitPeriod();
    ++kept->bodies;
    if (++bodies == after) *nowhere = 1;
  }
}
