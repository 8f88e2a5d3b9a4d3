#include "leases.hpp"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <shared_mutex>

#include <fastdds/rtps/writer/LivelinessManager.h>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;
using Clock = std::chrono::steady_clock;
using Kind = eprosima::fastdds::dds::LivelinessQosPolicyKind;

using Assert = bool(rtps::LivelinessManager*, rtps::GUID_t, Kind, eprosima::fastrtps::Duration_t);
using Expired = bool(rtps::LivelinessManager*);

Assert* original() noexcept {
  static Assert* const found = takt::dds::replaced<Assert>(
      "_ZN8eprosima8fastrtps4rtps17LivelinessManager17assert_livelinessENS1_6GUID_tENS_7fastdds3dds"
      "23LivelinessQosPolicyKindENS0_6Time_tE");
  return found;
}

}  // namespace

namespace takt::dds {

void renew_leases_quietly() noexcept {
  static_cast<void>(original());
  static_cast<void>(replaced<Expired>("_ZN8eprosima8fastrtps4rtps17LivelinessManager13timer_expiredEv"));
}

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// The timer keeps its time if the writer was alive: it expires before all leases, and then looks for the
// next.
bool LivelinessManager::assert_liveliness(GUID_t guid, LivelinessQosPolicyKind kind, Duration_t lease) {
  if (kind == Kind::MANUAL_BY_TOPIC_LIVELINESS_QOS) {
    const std::shared_lock list{col_mutex_};
    const std::lock_guard lock{mutex_};
    for (LivelinessData& writer : writers_) {
      if (writer.guid != guid || writer.kind != kind || !(writer.lease_duration == lease)) continue;
      if (writer.status != LivelinessData::WriterStatus::ALIVE) break;
      writer.time = Clock::now() + std::chrono::nanoseconds{lease.to_ns()};
      return true;
    }
  }
  return original()(this, guid, kind, lease);
}

bool LivelinessManager::timer_expired() {
  std::optional<LivelinessData> lost;
  {
    const std::lock_guard lock{mutex_};
    if (timer_owner_ != nullptr && timer_owner_->time <= Clock::now()) {
      timer_owner_->status = LivelinessData::WriterStatus::NOT_ALIVE;
      lost = *timer_owner_;
    }
  }
  if (lost && callback_) callback_(lost->guid, lost->kind, lost->lease_duration, -1, 1);
  if (!calculate_next()) return false;
  const std::lock_guard lock{mutex_};
  if (timer_owner_ == nullptr) return false;
  const std::chrono::duration<double, std::milli> left = timer_owner_->time - Clock::now();
  timer_.update_interval_millisec(std::max(left.count(), 0.0));
  return true;
}

}  // namespace eprosima::fastrtps::rtps
