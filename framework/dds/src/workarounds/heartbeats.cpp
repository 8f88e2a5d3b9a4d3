#include "heartbeats.hpp"

#include <cstddef>
#include <utility>

#include <fastdds/rtps/writer/StatefulWriter.h>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;
using takt::dds::Answers;

using Send = void(rtps::StatefulWriter*, std::size_t, rtps::RTPSMessageGroup&, bool, bool);

Send* original() noexcept {
  static Send* const found = takt::dds::replaced<Send>(
      "_ZN8eprosima8fastrtps4rtps14StatefulWriter19send_heartbeat_nts_EmRNS1_16RTPSMessageGroupEbb");
  return found;
}

thread_local Answers wanted = Answers::as_usual;

}  // namespace

namespace takt::dds {

HeartbeatsAsk::HeartbeatsAsk(Answers answers) noexcept : outer_(std::exchange(wanted, answers)) {}
HeartbeatsAsk::~HeartbeatsAsk() { wanted = outer_; }

void prepare_heartbeats() noexcept { static_cast<void>(original()); }

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// `final`: a reader answers only if it misses a sample.
void StatefulWriter::send_heartbeat_nts_(std::size_t readers, RTPSMessageGroup& message, bool final,
                                         bool liveliness) {
  if (wanted != Answers::as_usual) final = wanted == Answers::if_sample_is_missing;
  original()(this, readers, message, final, liveliness);
}

}  // namespace eprosima::fastrtps::rtps
