#include "causes.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

namespace takt::flight {

namespace {

using std::chrono::microseconds;

constexpr Nanoseconds kLeastLate = microseconds{20};
/// The times assumed for one page fault. A minor fault counts as at least kMinorFault, even if a faster time
/// was measured in a loop, because a fault in a run() often costs more. A major fault reads from a disk.
constexpr Nanoseconds kMinorFault = microseconds{2};
constexpr Nanoseconds kMajorFault = microseconds{100};

Nanoseconds median(std::vector<Nanoseconds> values) {
  if (values.empty()) return Nanoseconds{0};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Compares the delay with the times that the thread lost by preemption, by page faults and to the
/// hypervisor. Returns the cause with the greatest time, if this time is at least half of the delay. While the
/// hypervisor has taken the CPU, a ready thread waits too, so only the rest of its wait is preemption.
std::optional<Cause> accounts_for(const Evidence& e, Nanoseconds minor_fault, Nanoseconds delay) {
  const std::array<std::pair<Cause, Nanoseconds>, 3> weighed{
      {{Cause::preemption, e.stopped ? delay : e.waited - e.stolen},
       {Cause::page_fault, std::max(minor_fault, kMinorFault) * static_cast<std::int64_t>(e.minor_faults) +
                               kMajorFault * static_cast<std::int64_t>(e.major_faults)},
       {Cause::hypervisor, e.stolen}}};
  const auto greatest = std::max_element(weighed.begin(), weighed.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
  if (greatest->second * 2 < delay) return std::nullopt;
  return greatest->first;
}

class Judge {
 public:
  Judge(const Recording& recording, std::size_t executor, const Timeline& line)
      : recording_(recording), executor_(executor), line_(line) {
    const Nanoseconds basic = recording.executors[executor].basic_period;
    usual_ = usual_of(line, basic);
    std::map<std::uint32_t, std::vector<Nanoseconds>> took;
    std::map<std::uint32_t, std::vector<Nanoseconds>> after;
    for (const Row& row : line.rows) {
      for (std::size_t i = row.first_run; i < row.end_run; ++i) {
        const Run& run = line.runs[i];
        if (run.ended) took[run.module].push_back(run.took());
        after[run.module].push_back(Nanoseconds{run.start_ns - row.start_ns});
      }
    }
    for (auto& [module, values] : took) took_[module] = median(std::move(values));
    for (auto& [module, values] : after) after_[module] = median(std::move(values));
  }

  std::vector<LateStart> all() {
    for (std::size_t r = 0; r < line_.rows.size(); ++r) {
      if (r > 0) judge_row(r);
      for (std::size_t i = line_.rows[r].first_run; i < line_.rows[r].end_run; ++i) judge_run(r, i);
    }
    return std::move(found_);
  }

 private:
  /// Of the runs with the indexes `first` to `end` - 1, returns the run that exceeded its module's usual time
  /// most.
  std::optional<std::size_t> longest(std::size_t first, std::size_t end) const {
    std::optional<std::size_t> worst;
    Nanoseconds most{0};
    for (std::size_t i = first; i < end; ++i) {
      const Nanoseconds beyond = line_.runs[i].took() - usually(line_.runs[i].module);
      if (worst && beyond <= most) continue;
      worst = i;
      most = beyond;
    }
    return worst;
  }
  Nanoseconds usually(std::uint32_t module) const {
    const auto found = took_.find(module);
    return found == took_.end() ? Nanoseconds{0} : found->second;
  }
  void blame(LateStart& late, std::size_t run) const {
    late.culprit = line_.runs[run].module;
    late.took = line_.runs[run].took();
    late.usual = usually(*late.culprit);
  }
  Evidence evidence(std::int64_t from_ns, std::int64_t to_ns) const {
    return evidence_between(recording_.samples, executor_, 0, from_ns, to_ns);
  }

  void judge_row(std::size_t r) {
    const Row& row = line_.rows[r];
    const Row& before = line_.rows[r - 1];
    if (!before.ended)
      // The host died in the previous row, so no executor was running when this row was due.
      return;
    const Nanoseconds basic = recording_.executors[executor_].basic_period;
    LateStart late{.run = std::nullopt, .row = r};
    late.due_ns = row.release_ns;
    if (basic > Nanoseconds{0} && row.release_ns > before.release_ns) {
      late.missed = static_cast<std::uint64_t>((row.release_ns - before.release_ns) / basic.count());
      late.missed -= late.missed > 0 ? 1 : 0;
      late.due_ns -= static_cast<std::int64_t>(late.missed) * basic.count();
    }
    late.late = Nanoseconds{row.start_ns - late.due_ns};
    if (late.late <= usual_.threshold) return;

    if (before.end_ns > late.due_ns) {
      late.cause = Cause::own_overrun;
      const bool longer = before.took() > usual_.row + usual_.threshold;
      const LateStart* const cause_before = row_found(r - 1);
      if (!longer && cause_before != nullptr) {
        // The previous row took no longer than usual, but began late. So the cause of its late start is also
        // the cause of this row's late start.
        const LateStart first = *cause_before;
        late.cause = first.cause;
        late.culprit = first.culprit;
        late.took = first.took;
        late.usual = first.usual;
        late.evidence = first.evidence;
      } else {
        if (const auto worst = longest(before.first_run, before.end_run)) blame(late, *worst);
        late.evidence = evidence(before.start_ns, before.end_ns);
        const Nanoseconds delay = longer ? before.took() - usual_.row : late.late;
        if (const auto seen = accounts_for(late.evidence, recording_.minor_fault, delay)) late.cause = *seen;
      }
    } else {
      late.evidence = evidence(late.due_ns, row.start_ns);
      const auto seen = accounts_for(late.evidence, recording_.minor_fault, late.late);
      late.cause = seen ? *seen : late.evidence.looked ? Cause::wake_up : Cause::unknown;
    }
    last_row_ = {r, found_.size()};
    found_.push_back(std::move(late));
  }

  const LateStart* row_found(std::size_t r) const {
    return last_row_ && last_row_->first == r ? &found_[last_row_->second] : nullptr;
  }

  // Adds the run to found_ if the run began later in its row than usual. The delay of the row itself does not
  // count here, because judge_row() reports it.
  void judge_run(std::size_t r, std::size_t i) {
    const Row& row = line_.rows[r];
    const Run& run = line_.runs[i];
    if (i == row.first_run) return;
    LateStart late{.run = i, .row = r};
    late.due_ns = row.start_ns + after_.at(run.module).count();
    late.late = Nanoseconds{run.start_ns - late.due_ns};
    if (late.late <= usual_.threshold) return;
    late.cause = Cause::predecessor;
    if (const auto worst = longest(row.first_run, i)) {
      blame(late, *worst);
      late.evidence = evidence(line_.runs[*worst].start_ns, line_.runs[*worst].end_ns);
      if (const auto seen = accounts_for(late.evidence, recording_.minor_fault, late.took - late.usual))
        late.cause = *seen;
    }
    found_.push_back(std::move(late));
  }

  const Recording& recording_;
  std::size_t executor_;
  const Timeline& line_;
  Usual usual_;
  std::map<std::uint32_t, Nanoseconds> took_;
  std::map<std::uint32_t, Nanoseconds> after_;
  std::vector<LateStart> found_;
  // The index of the last late row, and the index of its entry in found_.
  std::optional<std::pair<std::size_t, std::size_t>> last_row_;
};

}  // namespace

const char* to_text(Cause cause) noexcept {
  switch (cause) {
    case Cause::own_overrun:
      return "own overrun";
    case Cause::predecessor:
      return "predecessor";
    case Cause::wake_up:
      return "wake-up";
    case Cause::preemption:
      return "preemption";
    case Cause::page_fault:
      return "page fault";
    case Cause::hypervisor:
      return "hypervisor";
    case Cause::unknown:
      return "unknown";
  }
  return "?";
}

Usual usual_of(const Timeline& line, Nanoseconds basic_period) {
  std::vector<Nanoseconds> late;
  std::vector<Nanoseconds> took;
  for (const Row& row : line.rows) {
    late.push_back(row.late());
    if (row.ended) took.push_back(row.took());
  }
  Usual usual{.threshold = kLeastLate, .row = median(std::move(took))};
  usual.threshold = std::max(kLeastLate, std::min(median(std::move(late)) * 10, basic_period / 2));
  return usual;
}

Evidence evidence_between(const std::vector<Sample>& samples, std::size_t executor, std::size_t thread,
                          std::int64_t from_ns, std::int64_t to_ns) {
  Evidence evidence;
  const auto use = [&](const Sample& sample) -> const os::ThreadUse* {
    if (executor >= sample.threads.size() || !sample.threads[executor][thread]) return nullptr;
    return &*sample.threads[executor][thread];
  };
  const auto later = [](std::int64_t time, const Sample& sample) { return time < sample.time_ns; };
  auto after =
      std::lower_bound(samples.begin(), samples.end(), to_ns,
                       [](const Sample& sample, std::int64_t time) { return sample.time_ns < time; });
  auto before = std::upper_bound(samples.begin(), samples.end(), from_ns, later);
  if (after == samples.end() || before == samples.begin()) return evidence;
  --before;
  const os::ThreadUse* const first = use(*before);
  const os::ThreadUse* const last = use(*after);
  if (first == nullptr || last == nullptr) return evidence;

  // Collect the time that the thread waited between each two samples. The median is the usual waiting time
  // for a wake-up; it is not evidence of a problem.
  std::vector<Nanoseconds> waits;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const os::ThreadUse* const a = use(samples[i - 1]);
    const os::ThreadUse* const b = use(samples[i]);
    if (a != nullptr && b != nullptr && b->waited >= a->waited) waits.push_back(b->waited - a->waited);
  }
  const Nanoseconds usual = median(std::move(waits)) * (after - before);
  const auto grown = [](auto a, auto b) { return b > a ? b - a : decltype(a){}; };
  evidence.looked = true;
  evidence.waited = std::max(Nanoseconds{0}, grown(first->waited, last->waited) - usual);
  evidence.gave_way = grown(first->gave_way, last->gave_way);
  evidence.minor_faults = grown(first->minor_faults, last->minor_faults);
  evidence.major_faults = grown(first->major_faults, last->major_faults);
  evidence.stopped = std::any_of(before, after + 1, [&](const Sample& sample) {
    const os::ThreadUse* const seen = use(sample);
    return seen != nullptr && seen->stopped;
  });
  const auto cpu = static_cast<std::size_t>(std::max(last->cpu, 0));
  if (cpu < before->stolen.size() && cpu < after->stolen.size())
    evidence.stolen = grown(before->stolen[cpu], after->stolen[cpu]);
  return evidence;
}

std::vector<LateStart> late_starts(const Recording& recording, std::size_t executor, const Timeline& line) {
  return Judge{recording, executor, line}.all();
}

std::string in_short(Nanoseconds duration) {
  const auto ns = static_cast<double>(duration.count());
  const double size = ns < 0 ? -ns : ns;
  if (size < 1e3) return std::to_string(duration.count()) + " ns";
  const auto in = [ns](double unit, const char* name) {
    const double value = ns / unit;
    const double digits = value < 0 ? -value : value;
    return fmt::format("{:.{}f} {}", value, digits < 9.995 ? 2 : digits < 99.95 ? 1 : 0, name);
  };
  return size < 999.5e3 ? in(1e3, "us") : size < 999.5e6 ? in(1e6, "ms") : in(1e9, "s");
}

std::string in_words(const LateStart& late, const std::vector<Module>& modules) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (late.culprit && *late.culprit < modules.size()) {
    const Module& module = modules[*late.culprit];
    add(module.name + " ran " + in_short(late.took) + (late.run ? " before it" : " in the previous row") +
        " (usually " + in_short(late.usual) +
        (module.budget > Nanoseconds{0} ? ", budget " + in_short(module.budget) : "") + ")");
  }
  if (late.missed != 0) add(std::to_string(late.missed) + (late.missed == 1 ? " row" : " rows") + " missed");
  const Evidence& e = late.evidence;
  if (e.stopped) add("a signal stopped its process");
  if (e.waited > microseconds{20} || (late.cause == Cause::preemption && !e.stopped)) add("waited " + in_short(e.waited) + " for a CPU");
  if (e.gave_way != 0)
    add("was preempted " + std::to_string(e.gave_way) + (e.gave_way == 1 ? " time" : " times"));
  if (e.minor_faults + e.major_faults != 0) {
    add(std::to_string(e.minor_faults + e.major_faults) +
        (e.minor_faults + e.major_faults == 1 ? " page fault" : " page faults") +
        (e.major_faults == 0 ? "" : ", " + std::to_string(e.major_faults) + " from disk"));
  }
  if (e.stolen > Nanoseconds{0}) add("the hypervisor took " + in_short(e.stolen));
  if (text.empty())
    text = e.looked ? "its thread woke up late; no other cause was found"
                    : "the kernel's counters of its thread were not read at that time";
  return text;
}

}  // namespace takt::flight
