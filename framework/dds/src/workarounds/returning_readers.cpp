#include "returning_readers.hpp"

#include <cstdint>
#include <mutex>

#include <fastdds/rtps/writer/ReaderProxy.h>
#include <fastdds/rtps/writer/StatefulWriter.h>
#include "replaced_function.hpp"
#include "resends.hpp"
#include "soon_repeated.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

using Acknack = bool(rtps::StatefulWriter*, const rtps::GUID_t&, const rtps::GUID_t&, std::uint32_t,
                     const rtps::SequenceNumberSet_t&, bool, bool&);

Acknack* original() noexcept {
  static Acknack* const found = takt::dds::replaced<Acknack>(
      "_ZN8eprosima8fastrtps4rtps14StatefulWriter15process_acknackERKNS1_6GUID_tES5_jRKNS0_11BitmapRange"
      "INS1_16SequenceNumber_tENS1_18SequenceNumberDiffELj256EEEbRb");
  return found;
}

}  // namespace

namespace takt::dds {

void send_again_to_returning_readers() noexcept { static_cast<void>(original()); }

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// Treats a request for a number that the writer counts as acknowledged as a request for all samples.
bool StatefulWriter::process_acknack(const GUID_t& writer, const GUID_t& reader, std::uint32_t count,
                                     const SequenceNumberSet_t& requested, bool final, bool& is_mine) {
  const std::lock_guard lock{mp_mutex};
  // A reader that has not received a heartbeat yet sends number 0.
  const bool answers = writer == m_guid && requested.base() > SequenceNumber_t{};
  if (answers) takt::dds::heartbeat_answered(writer, reader);
  if (answers && !requested.empty()) {
    for (const ReaderProxy* known : matched_remote_readers_) {
      if (known->guid() == reader && requested.base() <= known->changes_low_mark())
        return original()(this, writer, reader, count, SequenceNumberSet_t{SequenceNumber_t{}}, false,
                          is_mine);
    }
  }
  if (writer == m_guid &&
      !takt::dds::may_answer(writer, reader, requested))  // only the acknowledgement counts
    return original()(this, writer, reader, count, SequenceNumberSet_t{requested.base()}, true, is_mine);
  return original()(this, writer, reader, count, requested, final, is_mine);
}

}  // namespace eprosima::fastrtps::rtps
