#include "deferred_timers.hpp"

#include <cstddef>
#include <cstring>
#include <vector>

#include <fastdds/rtps/builtin/data/ParticipantProxyData.h>
#include <fastdds/rtps/resources/TimedEvent.h>
#include "replaced_function.hpp"

// Fast DDS does not install the header of its SecurityManager, so this file declares the functions by their
// mangled names.
#define REMOVE_PARTICIPANT \
  "_ZN8eprosima8fastrtps4rtps8security15SecurityManager18remove_participantERKNS1_20ParticipantProxyDataE"
#define DESTROY_TIMER "_ZN8eprosima8fastrtps4rtps10TimedEventD1Ev"

namespace {

using eprosima::fastrtps::rtps::ParticipantProxyData;
using eprosima::fastrtps::rtps::TimedEvent;

using Remove = void(void* manager, const ParticipantProxyData&);
using Destroy = void(void* timer);

Remove* original_remove() noexcept {
  static Remove* const found = takt::dds::replaced<Remove>(REMOVE_PARTICIPANT);
  return found;
}

Destroy* original_destroy() noexcept {
  static Destroy* const found = takt::dds::replaced<Destroy>(DESTROY_TIMER);
  return found;
}

// A copy of a timer, which only points to the state of the timer and to the thread that runs it.
struct alignas(TimedEvent) Timer {
  std::byte bytes[sizeof(TimedEvent)];
};

thread_local std::vector<Timer>* deferred = nullptr;

}  // namespace

namespace takt::dds {

void defer_deletion_of_timers() noexcept {
  static_cast<void>(original_remove());
  static_cast<void>(original_destroy());
}

}  // namespace takt::dds

void remove_participant(void* manager, const ParticipantProxyData& participant) asm(REMOVE_PARTICIPANT);
void destroy_timer(void* timer) asm(DESTROY_TIMER);

void remove_participant(void* manager, const ParticipantProxyData& participant) {
  std::vector<Timer> timers;
  deferred = &timers;
  original_remove()(manager, participant);
  deferred = nullptr;
  for (Timer& timer : timers) original_destroy()(&timer);
}

void destroy_timer(void* timer) {
  if (deferred == nullptr) return original_destroy()(timer);
  std::memcpy(&deferred->emplace_back(), timer, sizeof(Timer));
}
