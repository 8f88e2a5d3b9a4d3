#include <takt/component/service.hpp>

namespace takt {

const char* to_text(CallStatus status) noexcept {
  switch (status) {
    case CallStatus::idle:
      return "idle";
    case CallStatus::pending:
      return "pending";
    case CallStatus::replied:
      return "replied";
    case CallStatus::refused:
      return "refused";
    case CallStatus::timed_out:
      return "timed out";
    case CallStatus::nobody:
      return "nobody";
  }
  return "?";
}

}  // namespace takt
