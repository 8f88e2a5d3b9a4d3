#include "unmatched_writers.hpp"

#include <mutex>

#include <fastdds/rtps/history/ReaderHistory.h>
#include "replaced_function.hpp"

namespace eprosima::fastdds::dds::detail {

// Fast DDS does not install the header of this class; this declaration lists only the replaced function.
class DataReaderHistory : public fastrtps::rtps::ReaderHistory {
 public:
  void writer_not_alive(const fastrtps::rtps::GUID_t& writer);
};

}  // namespace eprosima::fastdds::dds::detail

namespace {

using eprosima::fastdds::dds::detail::DataReaderHistory;
using Forget = void(DataReaderHistory*, const eprosima::fastrtps::rtps::GUID_t&);

Forget* original() noexcept {
  static Forget* const found = takt::dds::replaced<Forget>(
      "_ZN8eprosima7fastdds3dds6detail17DataReaderHistory16writer_not_aliveERKNS_8fastrtps4rtps6GUID_tE");
  return found;
}

}  // namespace

namespace takt::dds {

void lock_readers_that_lose_writers() noexcept { static_cast<void>(original()); }

}  // namespace takt::dds

namespace eprosima::fastdds::dds::detail {

void DataReaderHistory::writer_not_alive(const fastrtps::rtps::GUID_t& writer) {
  const std::lock_guard lock{*getMutex()};
  original()(this, writer);
}

}  // namespace eprosima::fastdds::dds::detail
