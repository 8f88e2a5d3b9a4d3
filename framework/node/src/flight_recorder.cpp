#include <takt/node/flight_recorder.hpp>

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include <takt/flight/size.hpp>
#include <takt/flight/trace.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/machine.hpp>

namespace takt::node {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanoseconds kSampleEvery = milliseconds{50};
/// The time for which the recorder keeps the kernel's counters, and the records of what threads were doing
/// when their host died.
constexpr Nanoseconds kHistory = seconds{30};
constexpr std::size_t kMostChanges = 4096;
/// The time from a fault to its trace, so that the trace also shows the consequences of the fault.
constexpr Nanoseconds kAftermath = milliseconds{200};
constexpr Nanoseconds kTraceEvery = seconds{5};
/// The shortest interval between two faults because of missed rows. Missed rows recur when a cell overloads
/// its machine.
constexpr Nanoseconds kMissedEvery = seconds{60};
constexpr std::size_t kMostFileBytes = 32U << 20;
constexpr std::size_t kMostFiles = 8;
constexpr const char* kSuffix = ".trace.json";

std::string utc(std::int64_t wall_ns) {
  const std::time_t second = wall_ns / 1'000'000'000;
  std::tm parts{};
  ::gmtime_r(&second, &parts);
  return fmt::format("{:04}{:02}{:02}T{:02}{:02}{:02}.{:03}Z", parts.tm_year + 1900, parts.tm_mon + 1,
                     parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec, wall_ns / 1'000'000 % 1000);
}

}  // namespace

FlightRecorder::FlightRecorder(Options options, const schedule::DevicePlan& plan,
                               const channel::Channel& channel)
    : options_(std::move(options)), channel_(channel), died_(2 * plan.executors.size()) {
  for (const schedule::ExecutorPlan& executor : plan.executors)
    basic_periods_.push_back(executor.basic_period);
  machine_ = os::host_name();
  const os::Machine machine = os::read_machine();
  kernel_ = machine.kernel + " " + machine.version;
  minor_fault_ = os::measure_minor_fault();
}

Result<std::unique_ptr<FlightRecorder>> FlightRecorder::create(Options options,
                                                               const schedule::DevicePlan& plan,
                                                               const channel::Channel& channel) {
  auto record = channel::FlightRecord::create(flight::entries_for(plan));
  if (!record) return record.problems();
  std::unique_ptr<FlightRecorder> recorder{new FlightRecorder{std::move(options), plan, channel}};
  recorder->record_ = std::move(*record);
  recorder->worker_ = std::thread{[place = recorder.get()] { place->work(); }};
  return recorder;
}

FlightRecorder::~FlightRecorder() {
  static_cast<void>(finish());
  if (worker_.joinable()) worker_.join();
}

bool FlightRecorder::finish() {
  write_fault();
  {
    const std::lock_guard lock{mutex_};
    end_ = true;
  }
  news_.notify_all();
  return finished_;
}

void FlightRecorder::changed(flight::Change change) {
  if (changes_.size() == kMostChanges) changes_.pop_front();
  changes_.push_back(std::move(change));
}

void FlightRecorder::host_died(std::size_t executor) {
  const std::int64_t now_ns = to_ns(os::now());
  const channel::ExecutorBlock& block = channel_.executor(executor);
  for (const channel::Activity* activity : {&block.row, &block.sporadic}) {
    auto& died = died_[2 * executor + (activity == &block.row ? 0 : 1)];
    std::erase_if(died,
                  [now_ns](const flight::Open& open) { return now_ns - open.seen_ns > kHistory.count(); });
    const std::uint32_t module = activity->module.load();
    if (module == 0) continue;
    died.push_back({.module = module - 1,
                    .doing = activity->doing.load(),
                    .since_ns = activity->since_ns.load(),
                    .seen_ns = now_ns,
                    .host_died = true});
  }
}

void FlightRecorder::fault(const std::string& why) {
  ++faults_;
  if (!fault_.empty() && !only_missed_) return;
  if (fault_.empty()) fault_at_ = os::now();
  fault_ = why;
  only_missed_ = false;
}

void FlightRecorder::trace(Nanoseconds last, std::size_t most,
                           std::function<void(const Result<std::string>&)> done) {
  sample(os::now());
  enqueue({.recording = gather("requested", last), .most = most, .done = std::move(done)});
}

void FlightRecorder::step(Instant now) {
  if (now - sampled_at_ >= kSampleEvery) {
    sample(now);
    check_missed();
  }
  const bool again = !written_at_ || now - *written_at_ >= kTraceEvery;
  if (!fault_.empty() && again && now - fault_at_ >= kAftermath) write_fault();

  std::vector<Done> done;
  {
    const std::lock_guard lock{mutex_};
    done.swap(done_);
  }
  for (Done& each : done) each.done(std::move(each.text));
}

std::vector<std::string> FlightRecorder::messages() {
  const std::lock_guard lock{mutex_};
  return std::exchange(messages_, {});
}

void FlightRecorder::sample(Instant now) {
  sampled_at_ = now;
  flight::Sample sample{.time_ns = 0, .threads = {}, .stolen = os::read_stolen()};
  for (std::size_t e = 0; e < basic_periods_.size(); ++e) {
    const channel::ExecutorBlock& block = channel_.executor(e);
    sample.threads.emplace_back();
    for (std::size_t t = 0; t < 2; ++t) {
      const int thread = (t == 0 ? block.row : block.sporadic).thread.load(std::memory_order_relaxed);
      if (thread != 0) sample.threads.back()[t] = os::read_thread_use(thread);
    }
  }
  sample.time_ns = to_ns(os::now());
  while (!samples_.empty() && sample.time_ns - samples_.front().time_ns > kHistory.count())
    samples_.pop_front();
  samples_.push_back(std::move(sample));
}

void FlightRecorder::check_missed() {
  std::uint64_t missed = 0;
  for (std::size_t e = 0; e < basic_periods_.size(); ++e) missed += channel_.executor(e).missed.load();
  const std::uint64_t before = std::exchange(missed_, missed);
  const Instant now = os::now();
  if (missed <= before || (missed_at_ && now - *missed_at_ < kMissedEvery)) return;
  missed_at_ = now;
  const bool only = fault_.empty();
  fault(fmt::format("{} {} missed", missed - before, missed - before == 1 ? "row was" : "rows were"));
  only_missed_ = only;
}

flight::Recording FlightRecorder::gather(const std::string& why, Nanoseconds last) const {
  flight::Recording recording{.cell = options_.cell,
                              .device = options_.device,
                              .machine = machine_,
                              .kernel = kernel_,
                              .minor_fault = minor_fault_,
                              .why = why,
                              .taken_ns = to_ns(os::now()),
                              .wall_ns = os::wall_ns(),
                              .last = last,
                              .t0_ns = channel_.host(0).t0_ns.load(std::memory_order_acquire),
                              .modules = options_.modules,
                              .executors = {},
                              .changes = {changes_.begin(), changes_.end()},
                              .samples = {samples_.begin(), samples_.end()}};
  for (std::size_t e = 0; e < basic_periods_.size(); ++e) {
    recording.executors.push_back(
        {.name = options_.executors[e], .basic_period = basic_periods_[e], .threads = {}});
    for (std::size_t t = 0; t < 2; ++t) recording.executors[e].threads[t].open = died_[2 * e + t];
  }
  return recording;
}

void FlightRecorder::enqueue(Job job) {
  {
    const std::lock_guard lock{mutex_};
    jobs_.push_back(std::move(job));
  }
  news_.notify_all();
}

void FlightRecorder::write_fault() {
  if (fault_.empty()) return;
  std::string why = std::exchange(fault_, {});
  if (faults_ > 1) why += fmt::format("; {} more fault{}", faults_ - 1, faults_ == 2 ? "" : "s");
  faults_ = 0;
  // Missed rows have their own limit, so that the trace of a crash soon afterwards is not held back.
  if (!only_missed_) written_at_ = os::now();
  if (options_.files.empty()) return;
  sample(os::now());
  enqueue({.recording = gather(why, flight::kKept), .most = kMostFileBytes});
}

// The worker has the same priority as the rest of the node, because it shares locks and the heap with the
// node's main thread. On a busy machine, a worker of lower priority could hold a lock for seconds while the
// main thread waits for this lock.
//
// The worker first reads what a thread is doing, and then copies the thread's ring. If a run ends between
// these two steps, both results contain this run, and it counts as ended. The worker takes the time of the
// trace before both steps, because copying takes a while on a busy machine, and the end of the trace must not
// be later than the copied entries.
void FlightRecorder::work() {
  std::unique_lock lock{mutex_};
  while (true) {
    news_.wait(lock, [this] { return end_ || !jobs_.empty(); });
    if (jobs_.empty()) break;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    flight::Recording& recording = job.recording;
    recording.taken_ns = to_ns(os::now());
    recording.wall_ns = os::wall_ns();
    for (std::size_t e = 0; e < recording.executors.size(); ++e) {
      const channel::ExecutorBlock& block = channel_.executor(e);
      for (std::size_t t = 0; t < 2; ++t) {
        flight::Thread& thread = recording.executors[e].threads[t];
        const channel::Activity& activity = t == 0 ? block.row : block.sporadic;
        const std::uint32_t module = activity.module.load(std::memory_order_acquire);
        flight::Open open{.module = module - 1,
                          .doing = activity.doing.load(std::memory_order_acquire),
                          .since_ns = activity.since_ns.load(std::memory_order_acquire),
                          .seen_ns = to_ns(os::now())};
        if (module != 0 && activity.module.load(std::memory_order_relaxed) == module)
          thread.open.push_back(open);
        thread.copy = record_.copy(2 * e + t);
      }
    }
    std::string text = flight::trace_json(recording, job.most);
    if (!job.done) write_file(text, recording.wall_ns);
    lock.lock();
    if (job.done) done_.push_back({std::move(job.done), std::move(text)});
  }
  finished_ = true;
}

void FlightRecorder::write_file(const std::string& text, std::int64_t wall_ns) {
  namespace fs = std::filesystem;
  const std::string path = options_.files + "." + utc(wall_ns) + kSuffix;
  const auto written = os::replace_file(path, text);
  // The names contain the times of the traces, so sorting by name sorts by time.
  std::vector<fs::path> all;
  std::error_code ignored;
  const std::string begin = fs::path{options_.files}.filename().string() + ".";
  for (const auto& entry : fs::directory_iterator{fs::path{path}.parent_path(), ignored}) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begin) && name.ends_with(kSuffix)) all.push_back(entry.path());
  }
  std::sort(all.begin(), all.end());
  // A file whose name has a later time than the new file is older: the clock was set back after that file was
  // written.
  std::rotate(all.begin(), std::upper_bound(all.begin(), all.end(), fs::path{path}), all.end());
  for (std::size_t i = 0; i + kMostFiles < all.size(); ++i) fs::remove(all[i], ignored);
  const bool reported = std::exchange(write_failed_, !written) && !written;
  if (reported) return;
  const std::lock_guard lock{mutex_};
  messages_.push_back(written ? "a trace of the last few seconds was written; show it with takt trace " + path
                              : "warning: no trace was written: " + in_words(written.problems()));
}

}  // namespace takt::node
