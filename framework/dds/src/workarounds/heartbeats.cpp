#include "heartbeats.hpp"

#include <cstddef>
#include <utility>

#include "replaced_function.hpp"

#define SEND_HEARTBEAT TAKT_RTPS "14StatefulWriter19send_heartbeat_nts_EmRNS1_16RTPSMessageGroupEbb"

namespace takt::dds {

namespace {

using Send = void(void* writer, std::size_t readers, void* message, bool final, bool liveliness);

Send* original() noexcept {
  static Send* const found = replaced<Send>(SEND_HEARTBEAT);
  return found;
}

thread_local Answers wanted = Answers::as_usual;

}  // namespace

HeartbeatsAsk::HeartbeatsAsk(Answers answers) noexcept : outer_(std::exchange(wanted, answers)) {}
HeartbeatsAsk::~HeartbeatsAsk() { wanted = outer_; }

void prepare_heartbeats() noexcept { static_cast<void>(original()); }

void send_heartbeat(void* writer, std::size_t readers, void* message, bool final,
                    bool liveliness) asm(SEND_HEARTBEAT);

// `final`: a reader answers only if it misses a sample.
void send_heartbeat(void* writer, std::size_t readers, void* message, bool final, bool liveliness) {
  if (wanted != Answers::as_usual) final = wanted == Answers::if_sample_is_missing;
  original()(writer, readers, message, final, liveliness);
}

}  // namespace takt::dds
