#include "deferred_timers.hpp"

#include <vector>

#include "replaced_function.hpp"

#define REMOVE_PARTICIPANT \
  TAKT_RTPS "8security15SecurityManager18remove_participantERKNS1_20ParticipantProxyDataE"
#define DESTROY_TIMER TAKT_RTPS "10TimedEventD1Ev"

namespace takt::dds {

namespace {

using Remove = void(void* manager, const void* participant);
using Destroy = void(void* timer);

Remove* original_remove() noexcept {
  static Remove* const found = replaced<Remove>(REMOVE_PARTICIPANT);
  return found;
}

Destroy* original_destroy() noexcept {
  static Destroy* const found = replaced<Destroy>(DESTROY_TIMER);
  return found;
}

// A copy of a timer of Fast DDS.
struct Timer {
  void* functions;
  void* thread;
  void* state;
};

thread_local std::vector<Timer>* deferred = nullptr;

}  // namespace

void defer_deletion_of_timers() noexcept {
  static_cast<void>(original_remove());
  static_cast<void>(original_destroy());
}

void remove_authentication(void* manager, const void* participant) asm(REMOVE_PARTICIPANT);
void destroy_timer(void* timer) asm(DESTROY_TIMER);

void remove_authentication(void* manager, const void* participant) {
  std::vector<Timer> timers;
  deferred = &timers;
  original_remove()(manager, participant);
  deferred = nullptr;
  for (Timer& timer : timers) original_destroy()(&timer);
}

void destroy_timer(void* timer) {
  if (deferred == nullptr) return original_destroy()(timer);
  deferred->push_back(*static_cast<const Timer*>(timer));
}

}  // namespace takt::dds
