#include "removed_readers.hpp"

#include <utility>

#include <fastdds/rtps/writer/StatefulWriter.h>
#include "replaced_function.hpp"

namespace {

namespace rtps = eprosima::fastrtps::rtps;

using Remove = bool(rtps::StatefulWriter*, const rtps::GUID_t&);
using Check = void(rtps::StatefulWriter*);

Remove* original_remove() noexcept {
  static Remove* const found = takt::dds::replaced<Remove>(
      "_ZN8eprosima8fastrtps4rtps14StatefulWriter21matched_reader_removeERKNS1_6GUID_tE");
  return found;
}
Check* original_check() noexcept {
  static Check* const found =
      takt::dds::replaced<Check>("_ZN8eprosima8fastrtps4rtps14StatefulWriter18check_acked_statusEv");
  return found;
}

// The writer from which this thread is removing a reader.
thread_local const rtps::StatefulWriter* removes_from = nullptr;

}  // namespace

namespace takt::dds {

void remove_readers_without_deadlock() noexcept {
  static_cast<void>(original_remove());
  static_cast<void>(original_check());
}

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// Deletes the acknowledged samples after the destinations are unlocked.
bool StatefulWriter::matched_reader_remove(const GUID_t& reader) {
  const StatefulWriter* const outer = std::exchange(removes_from, this);
  const bool is_removed = original_remove()(this, reader);
  removes_from = outer;
  if (is_removed) original_check()(this);
  return is_removed;
}

void StatefulWriter::check_acked_status() {
  if (removes_from != this) original_check()(this);
}

}  // namespace eprosima::fastrtps::rtps
