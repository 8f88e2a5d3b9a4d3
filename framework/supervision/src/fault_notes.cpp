#include "fault_notes.hpp"

#include "member.hpp"

namespace takt::supervision {

using model::FaultKind;

void FaultNotes::note(FaultKind kind, const std::string& cause) const {
  if (noted_) noted_({.kind = kind, .cause = cause}, {});
}

void FaultNotes::note(const Member& member, FaultKind kind, const std::string& cause, ErrorType error,
                      const std::string& attachment) const {
  if (!noted_) return;
  noted_({.module = member.model.name,
          .kind = kind,
          .error = error == ErrorType::none ? "" : takt::to_text(error),
          .cause = cause,
          .attachment = attachment,
          .cycle = member.releases()},
         {});
}

void FaultNotes::note_line(const Member& member, FaultKind kind, const std::string& text,
                           std::uint64_t release, std::int64_t time_ns) const {
  if (!noted_) return;
  noted_({.time_ns = time_ns, .module = member.model.name, .kind = kind, .cause = text, .cycle = release},
         {});
}

void FaultNotes::note_increase(const Member* member, FaultKind kind, std::uint64_t& seen, std::uint64_t now,
                               const std::string& cause, const std::string& origin) const {
  const std::uint64_t before = std::exchange(seen, now);
  if (now <= before || !noted_) return;
  model::Fault fault{.kind = kind, .cause = cause, .count = now - before};
  if (member != nullptr) {
    fault.module = member->model.name;
    fault.cycle = member->releases();
  }
  noted_(std::move(fault), origin);
}

}  // namespace takt::supervision
