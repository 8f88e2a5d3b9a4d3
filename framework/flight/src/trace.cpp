#include <takt/flight/trace.hpp>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/channel/release_slot.hpp>
#include <takt/model/json.hpp>
#include "causes.hpp"
#include "timeline.hpp"

namespace takt::flight {

namespace {

using json = nlohmann::ordered_json;
using channel::FlightKind;

double in_us(std::int64_t ns) { return static_cast<double>(ns) / 1e3; }
double in_us(Nanoseconds duration) { return in_us(duration.count()); }

std::string quoted(const std::string& text) { return model::json_text(text); }

const char* outcome_of(std::uint64_t value) {
  switch (static_cast<channel::Release>(value)) {
    case channel::Release::given:
      return "given";
    case channel::Release::wake:
      return "woken";
    case channel::Release::pending:
      return "pending: the program is still in its body";
    case channel::Release::busy:
      return "dropped: the program is still in its body";
  }
  return "?";
}

// Writes a trace directly as text. A trace consists mostly of runs, and a JSON tree of the runs would take
// ten times as much memory.
class Writer {
 public:
  Writer(const Recording& recording, Nanoseconds last, std::size_t most)
      : r_(recording), from_ns_(recording.taken_ns - last.count()), last_(last), most_(most) {}

  /// Returns the trace, or std::nullopt if the trace would be longer than `most` bytes. If the trace covers
  /// no time (`last` is 0), returns it at any length.
  std::optional<std::string> write() {
    text_ = "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n";
    name("process_name", 0, "takt " + r_.cell + " " + r_.device);
    name("thread_name", thread_of_states(), "module states");
    for (std::size_t e = 0; e < r_.executors.size(); ++e) write_executor(e);
    for (std::uint32_t m = 0; m < r_.modules.size(); ++m) {
      if (has_bodies_.count(m) != 0)
        name("thread_name", thread_of_program(m), "program " + r_.modules[m].name);
    }
    for (const Change& change : r_.changes) write_change(change);
    text_ += "\n],\"otherData\":" + model::json_text(about()) + "}\n";
    if (too_long_ || (text_.size() > most_ && last_ > Nanoseconds{0})) return std::nullopt;
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void event(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    too_long_ |= text_.size() > most_ && last_ > Nanoseconds{0};
    if (too_long_) return;
    if (!first_) text_ += ",\n";
    first_ = false;
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }
  [[nodiscard]] double at(std::int64_t time_ns) const { return in_us(time_ns - from_ns_); }
  [[nodiscard]] std::string module_name(std::uint32_t index) const {
    return index < r_.modules.size() ? r_.modules[index].name : "module " + std::to_string(index);
  }
  [[nodiscard]] std::string port_name(std::uint32_t module, std::uint64_t place) const {
    if (module < r_.modules.size() && place < r_.modules[module].ports.size())
      return r_.modules[module].ports[place];
    return "port " + std::to_string(place);
  }

  void name(const char* what, std::uint32_t thread, const std::string& text) {
    event(R"({{"ph":"M","pid":1,"tid":{},"name":"{}","args":{{"name":{}}}}})", thread, what, quoted(text));
    if (std::string_view{what} == "thread_name")
      event(R"({{"ph":"M","pid":1,"tid":{},"name":"thread_sort_index","args":{{"sort_index":{}}}}})", thread,
            thread);
  }

  void write_executor(std::size_t e) {
    const Executor& executor = r_.executors[e];
    for (std::size_t t = 0; t < executor.threads.size(); ++t) {
      const Thread& thread = executor.threads[t];
      const Timeline line = timeline_of(thread, t == 0, from_ns_);
      const std::string label =
          t == 0 ? "executor " + executor.name : "executor " + executor.name + ", sporadic";
      const std::uint32_t id = thread_of_executor(e, t);
      if (t == 0 || !line.runs.empty()) name("thread_name", id, label);
      json facts{{"name", label},
                 {"thread", id},
                 {"executor", executor.name},
                 {"rows", line.rows.size()},
                 {"runs", line.runs.size()},
                 {"entries", thread.copy.entries.size()},
                 {"lost", thread.copy.lost},
                 {"older", thread.copy.written - thread.copy.entries.size() - thread.copy.lost}};
      lost_ += thread.copy.lost;
      if (!thread.copy.entries.empty())
        facts["holds_us"] = in_us(r_.taken_ns - thread.copy.entries.front().time_ns);
      if (t == 0) {
        const Usual usual = usual_of(line, executor.basic_period);
        facts["basic_period_us"] = in_us(executor.basic_period);
        facts["late_beyond_us"] = in_us(usual.threshold);
        const std::vector<LateStart> late = late_starts(r_, e, line);
        facts["late"] = late.size();
        write_rows(line, id, late);
      } else {
        for (const Run& run : line.runs) write_run(run, id, nullptr);
      }
      threads_.push_back(std::move(facts));
      for (const Mark& mark : line.marks) write_mark(mark, id);
      for (const Run& body : line.bodies) {
        if (body.start_ns < from_ns_ || body.end_ns < body.start_ns) continue;
        has_bodies_.insert(body.module);
        event(R"({{"ph":"X","pid":1,"tid":{},"ts":{:.3f},"dur":{:.3f},"cat":"body","name":{}}})",
              thread_of_program(body.module), at(body.start_ns), in_us(body.took()),
              quoted(module_name(body.module)));
      }
    }
  }

  void write_rows(const Timeline& line, std::uint32_t id, const std::vector<LateStart>& late) {
    auto next = late.begin();
    for (std::size_t r = 0; r < line.rows.size(); ++r) {
      const Row& row = line.rows[r];
      const LateStart* of_row = nullptr;
      if (next != late.end() && next->row == r && !next->run) of_row = &*next++;
      event(R"({{"ph":"X","pid":1,"tid":{},"ts":{:.3f},"dur":{:.3f},"cat":"row","name":"row",)"
            R"("args":{{"release_us":{:.3f},"late_us":{:.3f}{}{}}}}})",
            id, at(row.start_ns), in_us(row.took()), at(row.release_ns), in_us(row.late()),
            row.ended ? "" : ",\"ended\":false", of_row == nullptr ? "" : late_text(*of_row));
      for (std::size_t i = row.first_run; i < row.end_run; ++i) {
        const LateStart* of_run = nullptr;
        if (next != late.end() && next->run == i) of_run = &*next++;
        write_run(line.runs[i], id, of_run);
      }
    }
  }

  void write_run(const Run& run, std::uint32_t id, const LateStart* late) {
    std::string arguments = run.ended ? "" : ",\"ended\":false";
    if (late != nullptr) arguments += late_text(*late);
    if (!arguments.empty()) arguments = ",\"args\":{" + arguments.substr(1) + "}";
    event(R"({{"ph":"X","pid":1,"tid":{},"ts":{:.3f},"dur":{:.3f},"cat":"run","name":{}{}}})", id,
          at(run.start_ns), in_us(run.took()), quoted(module_name(run.module)), arguments);
  }

  [[nodiscard]] std::string late_text(const LateStart& late) const {
    std::string text =
        fmt::format(R"(,"due_us":{:.3f},"begins_late_us":{:.3f},"cause":"{}","why":{})", at(late.due_ns),
                    in_us(late.late), to_text(late.cause), quoted(in_words(late, r_.modules)));
    if (late.missed != 0) text += fmt::format(",\"missed\":{}", late.missed);
    if (late.culprit) {
      text += fmt::format(R"(,"culprit":{},"took_us":{:.3f},"usual_us":{:.3f})",
                          quoted(module_name(*late.culprit)), in_us(late.took), in_us(late.usual));
    }
    return text;
  }

  void write_mark(const Mark& mark, std::uint32_t id) {
    const std::string module = module_name(mark.module);
    switch (mark.kind) {
      case FlightKind::released:
        event(
            R"({{"ph":"i","s":"t","pid":1,"tid":{},"ts":{:.3f},"cat":"release","name":{},"args":{{"release":"{}"}}}})",
            id, at(mark.time_ns), quoted("release " + module), outcome_of(mark.value));
        break;
      case FlightKind::ready:
        event(R"({{"ph":"i","s":"t","pid":1,"tid":{},"ts":{:.3f},"cat":"release","name":{}}})", id,
              at(mark.time_ns), quoted("ready " + module));
        break;
      case FlightKind::swapped:
        event(R"({{"ph":"i","s":"t","pid":1,"tid":{},"ts":{:.3f},"cat":"swap","name":{}}})", id,
              at(mark.time_ns), quoted("swapped " + module));
        break;
      case FlightKind::write:
      case FlightKind::event: {
        const bool out = mark.kind == FlightKind::write;
        event(R"({{"ph":"i","s":"t","pid":1,"tid":{},"ts":{:.3f},"cat":"{}","name":{}}})", id,
              at(mark.time_ns), out ? "write" : "event",
              quoted((out ? "write " : "event ") + module + "." + port_name(mark.module, mark.value)));
        break;
      }
      default:
        break;
    }
  }

  void write_change(const Change& change) {
    if (change.time_ns < from_ns_) return;
    event(R"({{"ph":"i","s":"t","pid":1,"tid":{},"ts":{:.3f},"cat":"state","name":{},"args":)"
          R"({{"module":{},"event":"{}","from":"{}","to":"{}","text":{}}}}})",
          thread_of_states(), at(change.time_ns),
          quoted(module_name(change.module) + ": " + change.from + " -> " + change.to),
          quoted(module_name(change.module)), change.event, change.from, change.to, quoted(change.text));
  }

  [[nodiscard]] json about() const {
    json facts{{"format", kTraceFormat},
               {"cell", r_.cell},
               {"device", r_.device},
               {"machine", r_.machine},
               {"kernel", r_.kernel},
               {"why", r_.why},
               {"taken_utc_ns", r_.wall_ns},
               {"begins_utc_ns", r_.wall_ns - last_.count()},
               {"lasts_us", in_us(last_)},
               {"samples", r_.samples.size()},
               {"lost", lost_}};
    if (r_.t0_ns != 0) facts["t0_us"] = at(r_.t0_ns);
    if (last_ < r_.last) facts["left_out_us"] = in_us(r_.last - last_);
    facts["threads"] = threads_;
    return facts;
  }

  const Recording& r_;
  std::int64_t from_ns_;
  Nanoseconds last_;
  std::size_t most_;
  bool too_long_ = false;
  std::string text_;
  bool first_ = true;
  std::uint64_t lost_ = 0;
  std::set<std::uint32_t> has_bodies_;
  json threads_ = json::array();
};

}  // namespace

std::string trace_json(const Recording& recording, std::size_t most) {
  std::int64_t oldest_ns = recording.taken_ns;
  for (const Executor& executor : recording.executors) {
    for (const Thread& thread : executor.threads) {
      if (!thread.copy.entries.empty()) oldest_ns = std::min(oldest_ns, thread.copy.entries.front().time_ns);
    }
  }
  Nanoseconds last = recording.last;
  while (true) {
    if (auto text = Writer{recording, last, most}.write()) return std::move(*text);
    last = std::min(last, Nanoseconds{recording.taken_ns - oldest_ns}) / 2;
  }
}

}  // namespace takt::flight
