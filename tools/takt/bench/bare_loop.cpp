#include "bare_loop.hpp"

#include <takt/os/clock.hpp>
#include <takt/os/platform.hpp>
#include <takt/os/real_time.hpp>

namespace takt::bench {

void Loop::add(const Loop& other) {
  jitter.insert(jitter.end(), other.jitter.begin(), other.jitter.end());
  missed += other.missed;
  cpu_time += other.cpu_time;
  if (refused.empty()) refused = other.refused;
}

Grid Grid::from_now(Nanoseconds period, Nanoseconds length) {
  return {.first = os::now() + std::chrono::milliseconds{5}, .period = period, .length = length};
}

Loop loop_on_grid(const Grid& grid, const std::function<Instant(Instant)>& wait,
                  const std::function<void(Instant)>& body) {
  Loop loop;
  loop.jitter.resize(grid.instants());
  std::size_t count = 0;
  const Nanoseconds used = os::thread_time();
  const Instant end = grid.first + grid.period * static_cast<std::int64_t>(grid.instants());
  for (Instant release = grid.first; release < end; release += grid.period) {
    const Instant now = wait(release);
    // Periods that have passed completely count as missed, as for an executor.
    const auto passed = (now - release) / grid.period;
    release += passed * grid.period;
    loop.missed += static_cast<std::uint64_t>(passed);
    if (release >= end || count == loop.jitter.size()) break;
    loop.jitter[count++] = (release - now).count();
    if (body) body(release);
  }
  loop.cpu_time = os::thread_time() - used;
  loop.jitter.resize(count);
  return loop;
}

Instant sleep_to(Instant release) {
  os::sleep_until(release);
  return os::now();
}

Result<Loop> run_at(const Scheduling& scheduling, const std::function<Loop()>& loop) {
  Loop result;
  Problems refused;
  auto thread = os::Thread::start(
      {.name = "bench", .priority = scheduling.priority, .cpus = {scheduling.cpu}}, [&] { result = loop(); },
      &refused);
  if (!thread) return thread.problems();
  thread->join();
  result.refused = refused;
  return result;
}

Result<Loop> run_bare_loop(const Scheduling& scheduling, Nanoseconds period, Nanoseconds length) {
  return run_at(scheduling, [=] { return loop_on_grid(Grid::from_now(period, length), sleep_to); });
}

}  // namespace takt::bench
