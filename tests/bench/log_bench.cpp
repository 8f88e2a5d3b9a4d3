// Measures how long a log call takes. For comparison, also measures fmt::format_to_n() and snprintf(), which
// format the text during the call. The time for reading the log ring is not included.
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <takt/log.h>
#include <takt/component.hpp>
#include <takt/component/current_cycle.hpp>

namespace takt {
namespace {

/// Empties the ring without formatting its lines.
void empty(channel::LogRing& ring) {
  for (channel::LogRecord& record : ring.records) record.state.store(0, std::memory_order_relaxed);
  ring.claimed.store(0, std::memory_order_relaxed);
}

/// How many lines of level info fit into the ring.
constexpr std::size_t kLines = channel::LogRing::kRecords - channel::LogRing::kReserved;

/// Measures calls in batches, each of which fills the ring. The counter `per_line` is the time of one call.
template <class Call>
void measure(benchmark::State& state, Call&& call) {
  const auto ring = std::make_unique<channel::LogRing>();
  const Cycle cycle{.number = 12, .time = {}, .period = {}, .start = from_ns(1)};
  serve_cycle(&cycle, ring.get());
  double x = 0.5;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < kLines; ++i) call(x += 0.25);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    state.SetIterationTime(took.count());
    empty(*ring);
  }
  using benchmark::Counter;
  state.counters["per_line"] =
      Counter(static_cast<double>(kLines), Counter::kIsIterationInvariantRate | Counter::kInvert);
  if (ring->dropped[static_cast<std::size_t>(LogLevel::info)] != 0) state.SkipWithError("lines were dropped");
  serve_cycle(nullptr);
}

void LogWithoutArguments(benchmark::State& state) {
  measure(state, [](double) { log().info("lost the part"); });
}
void LogWithOneNumber(benchmark::State& state) {
  measure(state, [](double x) { log().info("lost the part at {} m", x); });
}
void LogWithThreeNumbersAndAText(benchmark::State& state) {
  measure(state, [](double x) { log().info("{} of {}: lost the part at {} m, {}", 3, 17, x, "go on"); });
}
void LogFromC(benchmark::State& state) {
  measure(state, [](double x) { takt_log(TAKT_LOG_INFO, "lost the part at %g m", x); });
}
void LogBelowTheLevel(benchmark::State& state) {
  measure(state, [](double x) { log().debug("lost the part at {} m", x); });
}
BENCHMARK(LogWithoutArguments)->UseManualTime();
BENCHMARK(LogWithOneNumber)->UseManualTime();
BENCHMARK(LogWithThreeNumbersAndAText)->UseManualTime();
BENCHMARK(LogFromC)->UseManualTime();
BENCHMARK(LogBelowTheLevel)->UseManualTime();

void LogIntoAFullRing(benchmark::State& state) {
  const auto ring = std::make_unique<channel::LogRing>();
  const Cycle cycle{};
  serve_cycle(&cycle, ring.get());
  double x = 0.5;
  for (auto _ : state) log().info("lost the part at {} m", x += 0.25);
  serve_cycle(nullptr);
}
BENCHMARK(LogIntoAFullRing);

void BaselineFmt(benchmark::State& state) {
  std::array<char, 256> text{};
  measure(state, [&text](double x) {
    benchmark::DoNotOptimize(fmt::format_to_n(text.data(), text.size(), "lost the part at {} m", x));
  });
}
void BaselineSnprintf(benchmark::State& state) {
  std::array<char, 256> text{};
  measure(state, [&text](double x) {
    benchmark::DoNotOptimize(std::snprintf(text.data(), text.size(), "lost the part at %g m", x));
  });
}
BENCHMARK(BaselineFmt)->UseManualTime();
BENCHMARK(BaselineSnprintf)->UseManualTime();

}  // namespace
}  // namespace takt

BENCHMARK_MAIN();
