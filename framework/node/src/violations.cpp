#include <takt/node/violations.hpp>

#include <algorithm>
#include <map>

#include <nlohmann/json.hpp>

#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/process.hpp>
#include <takt/os/system_calls.hpp>

namespace takt::node {

namespace {

using json = nlohmann::ordered_json;
using channel::ViolationLog;

}  // namespace

Result<Violations> Violations::create(std::size_t modules, std::size_t executors) {
  Violations violations;
  violations.modules_ = modules;
  violations.executors_ = executors;
  violations.library_ = os::private_directory() + "/libtakt_check.so";
  if (!os::is_shared_object(violations.library_)) {
    return fail("file not found: " + violations.library_,
                "install Takt again, or run without --check-realtime");
  }
  auto memory = os::SharedMemory::create("takt-check", sizeof(ViolationLog));
  if (!memory) return memory.problems();
  violations.memory_ = std::move(*memory);
  violations.reported_.assign(ViolationLog::kViolations, false);
  return violations;
}

const ViolationLog& Violations::log() const noexcept {
  return *reinterpret_cast<const ViolationLog*>(memory_.data());
}

std::vector<std::pair<std::string, std::string>> Violations::environment(
    std::vector<const os::Fd*>& inherit) const {
  inherit.push_back(&memory_.fd());
  const std::string before = os::environment("LD_PRELOAD");
  return {{"LD_PRELOAD", library_ + (before.empty() ? "" : ":" + before)},
          {channel::kCheckFd, std::to_string(memory_.fd().get())}};
}

SeenViolation Violations::in_words(const channel::Violation& violation,
                                   const std::vector<std::string>& paths) {
  SeenViolation seen{
      .module = violation.module,
      .hook = violation.hook == channel::Doing::nothing ? "" : channel::to_text(violation.hook),
      .kind = to_text(violation.kind),
      .what = std::string{violation.function.view()}};
  if (violation.kind == channel::ViolationKind::system_call)
    seen.what = os::system_call_name(violation.system_call);
  const std::size_t depth = std::min<std::size_t>(violation.depth, violation.frames.size());
  std::vector<std::string> objects;
  for (std::size_t i = 0; i < depth; ++i) {
    const channel::CodePlace& place = violation.frames[i];
    std::string object;
    if (place.object > 0 && place.object <= log().objects.size())
      object = log().objects[place.object - 1].path.view();
    // A module may run from a copy of its component in memory.
    if ((object.starts_with("/proc/") || object.starts_with("/memfd:")) && violation.module < paths.size())
      object = paths[violation.module];
    objects.push_back(std::move(object));
  }
  for (std::size_t i = 0; i < calls_of_module(objects, os::private_directory() + "/takt-host"); ++i) {
    seen.calls.push_back(symbols_.name(objects[i], violation.frames[i].address));
    if (seen.calls.back().starts_with("main ")) break;
  }
  return seen;
}

std::vector<SeenViolation> Violations::news(const std::vector<std::string>& paths) {
  std::vector<SeenViolation> news;
  for (std::size_t i = 0; i < log().violations.size(); ++i) {
    const channel::Violation& violation = log().violations[i];
    if (violation.key.load(std::memory_order_relaxed) == 0)
      break;  // entries are claimed in order, so all further entries are free
    // Skip an entry that record() in libtakt_check has claimed and not completed yet.
    if (reported_[i] || violation.ready.load(std::memory_order_acquire) == 0) continue;
    reported_[i] = true;
    const std::uint32_t number = violation.module & ~channel::kOfExecutor;
    if (number >= (number == violation.module ? modules_ : executors_)) continue;
    seen_.push_back({in_words(violation, paths), i});
    news.push_back(seen_.back().words);
  }
  return news;
}

std::vector<std::string> Violations::limitations() {
  const std::uint32_t bits = log().blind.load(std::memory_order_relaxed) & ~blind_reported_;
  blind_reported_ |= bits;
  std::vector<std::string> texts;
  if ((bits & ViolationLog::kNoSystemCalls) != 0)
    texts.emplace_back("system calls cannot be detected: that needs Linux 5.11 on x86-64");
  if ((bits & ViolationLog::kNoFaultPlaces) != 0)
    texts.emplace_back(
        "page faults are counted, but their source lines stay unknown: finding them needs Linux 5.13, and "
        "root or sysctl -w kernel.perf_event_paranoid=2");
  if (!dropped_reported_ && log().dropped.load(std::memory_order_relaxed) != 0) {
    dropped_reported_ = true;
    texts.push_back("there are more than " + std::to_string(ViolationLog::kViolations) +
                    " different violations, and only these are reported; correct them first");
  }
  return texts;
}

std::vector<std::pair<std::uint32_t, std::uint64_t>> Violations::counts() const {
  std::map<std::uint32_t, std::uint64_t> counts;
  for (const Seen& seen : seen_)
    counts[seen.words.module] += log().violations[seen.entry].count.load(std::memory_order_relaxed);
  return {counts.begin(), counts.end()};
}

json Violations::report(const model::Device& device) const {
  json list = json::array();
  for (const Seen& seen : seen_) {
    const SeenViolation& v = seen.words;
    const bool of_executor = (v.module & channel::kOfExecutor) != 0;
    json entry{{"module", of_executor ? "" : device.modules.at(v.module).name},
               {"hook", v.hook},
               {"kind", v.kind},
               {"what", v.what},
               {"count", log().violations[seen.entry].count.load(std::memory_order_relaxed)},
               {"backtrace", v.calls}};
    if (of_executor) entry["executor"] = device.executors.at(v.module & ~channel::kOfExecutor).name;
    list.push_back(std::move(entry));
  }
  return list;
}

std::string sentence_of(const SeenViolation& violation) {
  constexpr std::size_t kShown = 4;
  std::string text = (violation.what.empty() ? "" : violation.what + ", ") + std::string{"a"} +
                     (violation.kind == "allocation" ? "n " : " ") + violation.kind;
  // The sentence omits calls inside the C and C++ libraries; the report includes them.
  const std::string calls = called_by(violation.calls, kShown);
  return text + (calls.empty() ? "" : ", " + calls);
}

}  // namespace takt::node
