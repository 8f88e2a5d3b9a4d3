// The work of a simulated module in its run(), or in the body of a process module. The module reads its
// inputs, uses its run time, and writes its outputs. During this time it holds buffers of its links, as a
// real module may.
#include <algorithm>

#include "member.hpp"
#include "virtual_platform.hpp"

namespace takt::simulation {

namespace {

/// The probability that a sporadic module without an event port is ready in a row.
constexpr double kReady = 0.1;
/// The duration of a run that never returns.
constexpr Nanoseconds kForEver = std::chrono::hours{24 * 365};

}  // namespace

// Connects the module to its links, as the real host does when it loads a module.
void Device::connect(Member& member) {
  for (Member::Input& input : member.inputs) {
    input.reader = channel::LinkReader{input.link->link()};
    input.late = false;
  }
  for (Member::Output& output : member.outputs) output.writer = channel::LinkWriter{output.link->link()};
  member.entered = 0;
}

std::int64_t Device::news_at(const Member& member) const {
  std::int64_t first = channel::kNever;
  for (const Member::Input& input : member.inputs) {
    if (input.event) first = std::min(first, input.reader.news_at());
  }
  return first;
}

// Returns an error text if an input with stale="error" is too old; otherwise null. Checks the inputs in the
// same way as host::ThreadModule::check_inputs().
const char* Device::stale_input(Member& member, Instant start) {
  const std::uint64_t entered = member.block.entered.load();
  if (entered != member.entered) {
    member.entered = entered;
    member.watched_since = start;
  }
  const char* stale = nullptr;
  for (Member::Input& input : member.inputs) {
    channel::LinkBlock& block = input.link->link().block();
    if (block.deadline_ns <= 0) continue;
    const std::int64_t newest = std::max(block.newest_ns.load(), to_ns(member.watched_since));
    const bool late = to_ns(start) - newest > block.deadline_ns;
    if (late && !input.late) block.late.fetch_add(1);
    input.late = late;
    if (late && input.link->model().stale == model::Stale::error && stale == nullptr)
      stale = "the newest value of an input is older than its deadline";
  }
  return stale;
}

// True if the reader gets the safe value in place of the newest sample. Uses the same rule as InPort::read().
template <class Input>
bool Device::gets_safe_value(const Input& input) const {
  const channel::Link link = input.link->link();
  if (link.safe().empty()) return false;
  const channel::LinkBlock& block = link.block();
  const bool late = block.deadline_ns > 0 && to_ns(now()) - block.newest_ns.load() > block.deadline_ns;
  return late || block.written.load() < link.trusted_from();
}

executor::Outcome Device::work(Member& member, Instant release, Instant begin) {
  const Instant start = member.as_of(release, begin);
  const std::int64_t valid = member.logical ? to_ns(release + *member.model.period) : 0;
  if (member.is_thread()) {
    if (const char* stale = stale_input(member, start); stale != nullptr) return {ErrorType::stale, stale};
  }
  for (Member::Output& output : member.outputs) {
    write_first_half(output.writer.link().payload(output.writer.buffer()), output.link->number(),
                     number_of_next(output.writer));
  }
  // Takes all samples of each input, and keeps the buffer of the last one while the run takes time.
  for (Member::Input& input : member.inputs) {
    const bool safe = gets_safe_value(input);
    if (std::exchange(input.safe, safe) != safe)
      emit({.what = What::safe, .connection = input.link->connection(), .count = safe ? 1U : 0U});
    const std::uint32_t depth = input.link->link().depth();
    for (std::uint32_t i = 0; i < depth && input.reader.take(to_ns(start)); ++i) {
      const std::byte* sample = input.link->link().payload(input.reader.buffer());
      const std::uint32_t connection = input.link->connection();
      emit({.what = What::read,
            .connection = connection,
            .number = number_of(sample),
            .count = is_whole(sample, input.link->number()) ? 0U : 1U});
    }
  }
  Nanoseconds time = member.run_time.draw(member.draws);
  time += std::exchange(member.late_by, Nanoseconds{0});
  if (std::exchange(member.to_hang, false)) time = kForEver;
  const bool crashes = std::exchange(member.to_crash, false);
  world_.kernel.work(crashes ? time / 2 : time);
  if (crashes) {
    if (member.is_thread()) member.host->crash(member);
    member.process->leave(
        {.text = "was killed by SIGSEGV (Segmentation fault)", .signalled = true, .code = 11});
  }
  for (Member::Input& input : member.inputs) {
    const std::byte* sample = input.link->link().payload(input.reader.buffer());
    if (input.reader.info().sequence == 0 || is_whole(sample, input.link->number())) continue;
    emit({.what = What::read,
          .connection = input.link->connection(),
          .number = number_of(sample),
          .count = 1});
  }
  if (std::exchange(member.to_fail, false)) return "injected failure";
  for (Member::Output& output : member.outputs) {
    std::byte* const sample = output.writer.link().payload(output.writer.buffer());
    const std::uint64_t number = number_of_next(output.writer);
    write_second_half(sample, output.link->number(), number);
    output.writer.publish(kSampleBytes, to_ns(start), valid);
    wake_word().note(output.link->link().block().wake_bits);
    emit({.what = What::wrote, .connection = output.link->connection(), .number = number});
  }
  executor::Outcome outcome;
  outcome.finished = std::exchange(member.to_finish, false);
  return outcome;
}

executor::Outcome ThreadBody::run(const Cycle& cycle) noexcept {
  if (member_.scheduled()) device_.emit_table_changes(member_.executor);
  device_.emit({.what = What::run, .number = cycle.number, .release = cycle.time}, member_);
  const executor::Outcome outcome = device_.work(member_, cycle.time, cycle.start);
  device_.emit(
      {.what = What::ran, .number = cycle.number, .took = device_.now() - cycle.start, .error = outcome.type},
      member_);
  return outcome;
}

executor::Outcome ThreadBody::condition(const Cycle& cycle, bool* ready) noexcept {
  const bool by_event = std::any_of(member_.inputs.begin(), member_.inputs.end(),
                                    [](const Device::Member::Input& input) { return input.event; });
  *ready = by_event ? has_news(cycle.start) : member_.draws.chance(kReady);
  if (*ready)
    device_.emit({.what = What::ready,
                  .number = cycle.number,
                  .release = cycle.time,
                  .until = cycle.time + *member_.model.deadline},
                 member_);
  return {};
}

bool ThreadBody::has_news(Instant now) const noexcept { return device_.news_at(member_) <= to_ns(now); }

}  // namespace takt::simulation
