// The log lines of the modules: from their rings to the node's output and the fault record.
#include <algorithm>

#include <takt/core/log_level.hpp>
#include <takt/supervision/supervisor.hpp>
#include "fault_notes.hpp"
#include "member.hpp"

namespace takt::supervision {

namespace {

using model::FaultKind;

FaultKind kind_of(LogLevel level) {
  switch (level) {
    case LogLevel::error:
      return FaultKind::log_error;
    case LogLevel::warning:
      return FaultKind::log_warning;
    case LogLevel::info:
      return FaultKind::log_info;
    case LogLevel::debug:
      break;
  }
  return FaultKind::log_debug;
}

}  // namespace

void Supervisor::begin_log(Member& member, Instant now) {
  channel::LogRing* const ring = member.log_ring();
  if (ring == nullptr) return;
  member.log.emplace(*ring);
  member.log_limit.emplace(now);
  const auto given = model::given_property(member.model, kLogLevelProperty);
  if (!given) return;
  if (const auto level = log_level_from(*given); level)
    ring->level.store(static_cast<std::uint32_t>(*level), std::memory_order_relaxed);
}

void Supervisor::take_lines(Member& member, Instant now) {
  if (!member.log) return;
  for (std::size_t n = 0; n < channel::LogRing::kRecords; ++n) {
    const auto line = member.log->next(now);
    if (!line) break;
    if (!member.log_limit->takes(line->level, now)) continue;
    log(member, std::string{takt::to_text(line->level)} + ": " + line->text);
    notes_->note_line(member, kind_of(line->level), line->text, line->release, line->time_ns);
  }
  if (const bool stopped = member.in_safe_stop(); stopped != member.safe_stop_recorded) {
    member.safe_stop_recorded = stopped;
    if (stopped || member.state() == lifecycle::State::executing) {
      const std::string text = stopped ? kSafeStop : "its safe stop has ended";
      log(member, text);
      notes_->note_line(member, stopped ? FaultKind::log_warning : FaultKind::log_info, text);
    }
  }
  member.log_limit->add_lost(member.log->lost());
  if (const auto text = member.log_limit->report(now)) {
    log(member, *text);
    notes_->note_line(member, FaultKind::log_warning, *text);
  }
}

void Supervisor::log_level(const Member& member, const std::string* value,
                           const std::function<void(const Outcome&)>& done) {
  const auto refuse = [&](const std::string& text) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = text});
  };
  channel::LogRing* const ring = member.log_ring();
  if (ring == nullptr)
    return refuse(member.model.name +
                  " is a program without releases, which has no log; let it print its lines");
  if (value != nullptr) {
    const auto level = log_level_from(*value);
    if (!level) return refuse(in_words(level.problems()));
    ring->level.store(static_cast<std::uint32_t>(*level), std::memory_order_relaxed);
    log(member, std::string{kLogLevelProperty} + " = " + *value);
  }
  const auto level = static_cast<LogLevel>(std::clamp<std::uint32_t>(ring->threshold(), 1, 4));
  done({.code = REPLY_OK, .state = member.state(), .text = "", .value = takt::to_text(level)});
}

}  // namespace takt::supervision
