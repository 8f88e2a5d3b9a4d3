// Writes samples with increasing numbers. Each new instance starts at the time of day, in us, so its numbers
// are higher than those of earlier instances. A new value of `order` makes run() fail once. The last digit
// selects how: 1 crashes, 2 throws, 3 returns a failure, 4 never returns. The other digits only make the
// values different. Before it fails, the module prints "carries out ORDER at NS", with the time of day in ns,
// on standard error.
#include <takt/module.h>

#include <chrono>
#include <cstdio>

#include <samples_c.h>

TAKT_OUT_PORT(samples_Count, out);
TAKT_INTEGER(order, 0, 0, 1000000000, "", "What to do, once.");

namespace {

std::uint64_t number = 0;
std::int64_t done = 0;
volatile int* volatile nowhere = nullptr;
volatile bool for_ever = true;

std::int64_t time_of_day_ns() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

void obey() {
  done = order;
  std::fprintf(stderr, "carries out %lld at %lld\n", static_cast<long long>(done),
               static_cast<long long>(time_of_day_ns()));
  switch (done % 10) {
    case 1:
      *nowhere = 1;
      break;
    case 2:
      throw std::runtime_error("it was told to throw");
    case 3:
      takt_fail("it was told to fail");
      break;
    case 4:
      while (for_ever) {
      }
      break;
    default:
      break;
  }
}

void write_next() {
  samples_Count count{};
  count.number = ++number;
  for (double& same : count.same) same = static_cast<double>(number);
  count.few.length = static_cast<std::uint32_t>(number % 5);
  for (std::uint32_t i = 0; i < count.few.length; ++i)
    count.few.items[i] = static_cast<std::uint32_t>(number);
  takt_write(&out, &count);
}

}  // namespace

extern "C" {
void initialize(void) {
  number = static_cast<std::uint64_t>(time_of_day_ns() / 1000);
  done = order;  // do not fail: an earlier instance has already failed because of this value
}
void run(void) {
  if (order != done) return obey();
  write_next();
}
}
