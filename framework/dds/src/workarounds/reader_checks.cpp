#include "reader_checks.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

#include <fastdds/rtps/history/ReaderHistory.h>
#include <fastdds/rtps/reader/StatefulReader.h>
#include <fastdds/rtps/reader/StatelessReader.h>
#include <fastdds/dds/core/status/SampleRejectedStatus.hpp>

#include <takt/security/identity.hpp>
#include <takt/wire/rtps.hpp>
#include "replaced_function.hpp"

namespace eprosima::fastrtps::rtps {

// What a reader knows about a writer. A "number" in this file is a sequence number. Fast DDS does not install
// the header of this class; this declaration lists only the functions that this file uses.
class WriterProxy {
 public:
  const SequenceNumber_t available_changes_max() const;    // all numbers up to this one are received or lost
  std::size_t number_of_changes_from_writer() const;       // how many later numbers the writer has used
  void loaded_from_storage(const SequenceNumber_t& last);  // sets all numbers of this object to `last`
  std::int32_t lost_changes_update(const SequenceNumber_t& first);  // numbers before `first` are lost
  void missing_changes_update(const SequenceNumber_t& last);        // numbers up to `last` exist
  SequenceNumber_t next_cache_change_to_be_notified();
};

}  // namespace eprosima::fastrtps::rtps

namespace eprosima::fastdds::dds::detail {

struct DataReaderInstance;  // the samples of one key

// The samples of a reader. Fast DDS does not install the header of this class either.
class DataReaderHistory : public fastrtps::rtps::ReaderHistory {
  bool received_change_keep_last(fastrtps::rtps::CacheChange_t* sample, std::size_t missing,
                                 SampleRejectedStatusKind& why);
  bool completed_change_keep_last(fastrtps::rtps::CacheChange_t* sample, DataReaderInstance& same_key,
                                  std::size_t missing, SampleRejectedStatusKind& why);
};

}  // namespace eprosima::fastdds::dds::detail

namespace eprosima::fastdds::dds {

class DataReaderImpl {
 protected:
  bool on_new_cache_change_added(const fastrtps::rtps::CacheChange_t* sample);
};

}  // namespace eprosima::fastdds::dds

namespace eprosima::fastrtps::rtps::security {

class SecurityManager {
 public:
  void process_participant_stateless_message(const CacheChange_t* message);
};

}  // namespace eprosima::fastrtps::rtps::security

namespace {

namespace rtps = eprosima::fastrtps::rtps;

// A reader skips lost numbers all at once, except for the last kMostCounted, which it visits one by one.
// kMostCounted is larger than the number of samples that a reader of Takt keeps.
constexpr std::uint32_t kMostCounted = 65536;
// A GAP may begin after a number that the reader has not received yet. Then the reader stores at most
// kMostStored numbers of the GAP, and later asks the writer for the others again. A sample whose number is
// larger by more than this is not stored either: the writer sends it again when the reader asks for it.
constexpr std::uint32_t kMostStored = 4096;
// The number of samples of one writer of which a reader may have some fragments, but not all.
constexpr std::size_t kMostBegun = 256;
constexpr std::uint32_t kMostPayload = 65535;  // largest size of the content of a packet, in bytes
// Fast DDS assembles a sample in its own memory. At the first multiple of 4 in each missing fragment, it
// stores the 4-byte number of the next missing fragment. So Fast DDS needs up to kBehind bytes after the end
// of the sample.
constexpr std::uint32_t kIndex = 4;
constexpr std::uint32_t kBehind = 6;

/// The replaced functions of Fast DDS.
struct Originals {
  using Next = rtps::SequenceNumber_t(rtps::WriterProxy*);
  using Notify = void(rtps::StatefulReader*, rtps::WriterProxy*);
  using Data = bool(rtps::StatefulReader*, rtps::CacheChange_t*);
  using Add = bool(rtps::ReaderHistory*, rtps::CacheChange_t*);
  using Receive = bool(rtps::ReaderHistory*, rtps::CacheChange_t*, std::size_t,
                       eprosima::fastdds::dds::SampleRejectedStatusKind&);
  using Present = bool(eprosima::fastdds::dds::DataReaderImpl*, const rtps::CacheChange_t*);
  using Gap = bool(rtps::StatefulReader*, const rtps::GUID_t&, const rtps::SequenceNumber_t&,
                   const rtps::SequenceNumberSet_t&);
  using Fragments = bool(rtps::StatefulReader*, rtps::CacheChange_t*, std::uint32_t, std::uint32_t,
                         std::uint16_t);
  using BestEffortFragments = bool(rtps::StatelessReader*, rtps::CacheChange_t*, std::uint32_t, std::uint32_t,
                                   std::uint16_t);
  using Reserve = bool(rtps::RTPSReader*, rtps::CacheChange_t**, std::uint32_t);
  using Authenticate = void(rtps::security::SecurityManager*, const rtps::CacheChange_t*);

  Next* next = takt::dds::replaced<Next>(
      "_ZN8eprosima8fastrtps4rtps11WriterProxy32next_cache_change_to_be_notifiedEv");
  Notify* notify = takt::dds::replaced<Notify>(
      "_ZN8eprosima8fastrtps4rtps14StatefulReader13NotifyChangesEPNS1_11WriterProxyE");
  Data* data = takt::dds::replaced<Data>(
      "_ZN8eprosima8fastrtps4rtps14StatefulReader14processDataMsgEPNS1_13CacheChange_tE");
  Add* add =
      takt::dds::replaced<Add>("_ZN8eprosima8fastrtps4rtps13ReaderHistory10add_changeEPNS1_13CacheChange_tE");
  Receive* receive = takt::dds::replaced<Receive>(
      "_ZN8eprosima7fastdds3dds6detail17DataReaderHistory25received_change_keep_lastEPNS_8fastrtps4rtps"
      "13CacheChange_tEmRNS1_24SampleRejectedStatusKindE");
  Present* present = takt::dds::replaced<Present>(
      "_ZN8eprosima7fastdds3dds14DataReaderImpl25on_new_cache_change_addedEPKNS_8fastrtps4rtps13CacheChange_"
      "tE");
  Gap* gap = takt::dds::replaced<Gap>(
      "_ZN8eprosima8fastrtps4rtps14StatefulReader13processGapMsgERKNS1_6GUID_tERKNS1_16SequenceNumber_t"
      "ERKNS0_11BitmapRangeIS6_NS1_18SequenceNumberDiffELj256EEE");
  Fragments* fragments = takt::dds::replaced<Fragments>(
      "_ZN8eprosima8fastrtps4rtps14StatefulReader18processDataFragMsgEPNS1_13CacheChange_tEjjt");
  BestEffortFragments* best_effort_fragments = takt::dds::replaced<BestEffortFragments>(
      "_ZN8eprosima8fastrtps4rtps15StatelessReader18processDataFragMsgEPNS1_13CacheChange_tEjjt");
  Reserve* reserve = takt::dds::replaced<Reserve>(
      "_ZN8eprosima8fastrtps4rtps10RTPSReader12reserveCacheEPPNS1_13CacheChange_tEj");
  Authenticate* authenticate = takt::dds::replaced<Authenticate>(
      "_ZN8eprosima8fastrtps4rtps8security15SecurityManager37process_participant_stateless_messageEPKNS1_"
      "13CacheChange_tE");
};

const Originals& originals() noexcept {
  static const Originals found;
  return found;
}

std::atomic<std::uint64_t> refused{0};

/// Counts a packet that a reader ignores, and returns false.
bool refuse() noexcept {
  refused.fetch_add(1, std::memory_order_relaxed);
  return false;
}

/// Returns the largest size of a sample in fragments that this reader accepts, in bytes. A reader of Takt
/// knows the largest sample of its type.
std::uint32_t largest_sample(const rtps::RTPSReader& reader, rtps::History& history) {
  return reader.getGuid().is_builtin() ? kMostPayload : history.getTypeMaxSerialized();
}

/// Returns true if a DATA_FRAG contains the fragments that it claims to contain, and the reader accepts such
/// a long sample.
bool is_acceptable(const rtps::RTPSReader& reader, rtps::History& history, const rtps::CacheChange_t& part,
                   std::uint32_t sample, std::uint32_t first, std::uint32_t count) {
  const std::uint64_t size = part.getFragmentSize();
  if (size < kIndex || sample > largest_sample(reader, history) || first == 0 || count == 0) return false;
  const std::uint64_t begin = (first - 1) * size;
  if (begin + (count - 1) * size >= sample) return false;
  const std::uint32_t length = part.serializedPayload.length;
  return length <= kMostPayload && length >= std::min(count * size, sample - begin);
}

/// Returns the number of bytes in which Fast DDS assembles a sample.
std::uint64_t assembly_size(const rtps::CacheChange_t& part, std::uint32_t sample) {
  const std::uint64_t last = std::uint64_t{sample - 1} / part.getFragmentSize() * part.getFragmentSize();
  return std::max<std::uint64_t>(sample, (last + 3) / 4 * 4 + kIndex);
}

/// Returns true if a DATA_FRAG gives its sample and fragments the same sizes as the first DATA_FRAG did.
bool continues(const rtps::CacheChange_t& begun, const rtps::CacheChange_t& part, std::uint32_t sample) {
  return begun.getFragmentSize() == part.getFragmentSize() && begun.serializedPayload.length == sample;
}

/// Removes a sample of which some fragments are missing, so that the writer may send it again.
void forget(rtps::ReaderHistory& history, rtps::CacheChange_t& begun) {
  // Fast DDS would count the number of an incomplete sample as received.
  begun.setFragmentSize(0);
  history.remove_change(&begun);
}

/// Removes the samples for which `is_lost` returns true.
template <class IsLost>
void forget(rtps::ReaderHistory& history, IsLost&& is_lost) {
  std::vector<rtps::CacheChange_t*> lost;
  for (auto each = history.changesBegin(); each != history.changesEnd(); ++each) {
    if (is_lost(**each)) lost.push_back(*each);
  }
  for (rtps::CacheChange_t* each : lost) forget(history, *each);
}

/// Makes room for one more incomplete sample of a writer. Keeps the samples that the reader needs first.
bool make_room(rtps::ReaderHistory& history, const rtps::CacheChange_t& part) {
  std::size_t count = 0;
  rtps::CacheChange_t* last = nullptr;
  for (auto each = history.changesBegin(); each != history.changesEnd(); ++each) {
    if ((*each)->writerGUID != part.writerGUID || (*each)->is_fully_assembled()) continue;
    ++count;
    if (last == nullptr || (*each)->sequenceNumber > last->sequenceNumber) last = *each;
  }
  if (count < kMostBegun) return true;
  if (last->sequenceNumber < part.sequenceNumber) return false;
  forget(history, *last);
  return true;
}

// The sample that a reader drops on this thread, because it is older than all waiting samples of its key.
thread_local rtps::CacheChange_t* too_old = nullptr;

/// Lets `receive` pass a sample to this reader, and frees the sample if the reader drops it.
template <class Receive>
bool receive(rtps::RTPSReader& reader, Receive&& receive) {
  rtps::CacheChange_t* const outer = std::exchange(too_old, nullptr);
  const bool is_taken = receive();
  if (rtps::CacheChange_t* const dropped = std::exchange(too_old, outer)) reader.releaseCache(dropped);
  return is_taken;
}

// The reader that passes samples to its listener on this thread, and its history.
struct Notifying {
  rtps::StatefulReader* reader;
  rtps::ReaderHistory* history;
};
thread_local Notifying notifying{};

// Locked from the comparison with the first DATA_FRAG until the fragments are stored. The lock of the reader
// cannot be held so long, because Fast DDS needs to release it in between.
std::mutex storing_fragments;

}  // namespace

namespace takt::dds {

void check_what_readers_receive() noexcept { static_cast<void>(originals()); }

std::uint64_t refused_by_readers() noexcept { return refused.load(std::memory_order_relaxed); }

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps {

// Returns the next number that the reader passes to its listener, if there is a sample with this number.
SequenceNumber_t WriterProxy::next_cache_change_to_be_notified() {
  const SequenceNumber_t next = originals().next(this);
  const SequenceNumber_t last = available_changes_max();
  if (next == c_SequenceNumber_Unknown || last.to64long() - next.to64long() < kMostCounted) return next;
  // A sample with a skipped number may have been waiting. Fast DDS would not count it, but let the listener
  // take it, and with the next sample of its key, an assertion would end the process.
  forget(*notifying.history, [&](CacheChange_t& each) {
    WriterProxy* its = nullptr;
    return next <= each.sequenceNumber && each.sequenceNumber <= last - kMostCounted &&
           notifying.reader->matched_writer_lookup(each.writerGUID, &its) && its == this;
  });
  const auto used = static_cast<std::uint32_t>(number_of_changes_from_writer());
  loaded_from_storage(last - kMostCounted);
  lost_changes_update(last + 1);
  missing_changes_update(last + used);
  return originals().next(this);
}

void StatefulReader::NotifyChanges(WriterProxy* known) {
  const Notifying outer = std::exchange(notifying, {this, mp_history});
  originals().notify(this, known);
  notifying = outer;
}

bool StatefulReader::processGapMsg(const GUID_t& writer, const SequenceNumber_t& start,
                                   const SequenceNumberSet_t& list) {
  const std::lock_guard lock{mp_mutex};
  WriterProxy* known = nullptr;
  if (!is_alive_ || !acceptMsgFrom(writer, &known) || known == nullptr) return false;
  const SequenceNumber_t next = known->available_changes_max() + 1;
  const SequenceNumber_t end = list.base();
  if (start <= next && start < end) {
    known->lost_changes_update(end);
    return originals().gap(this, writer, end - 1, list);
  }
  const SequenceNumber_t limit = next + kMostStored;
  return originals().gap(this, writer, start, end > limit ? SequenceNumberSet_t{limit} : list);
}

bool StatefulReader::processDataMsg(CacheChange_t* sample) {
  {
    const std::lock_guard lock{mp_mutex};
    WriterProxy* known = nullptr;
    if (!is_alive_ || !acceptMsgFrom(sample->writerGUID, &known)) return false;
    // A sample that must wait for earlier ones is stored. It may be as long as its packet, which is much
    // longer than most types allow.
    if (known != nullptr) {
      const std::uint64_t next = known->available_changes_max().to64long() + 1;
      const std::uint64_t number = sample->sequenceNumber.to64long();
      const std::uint64_t ahead = number > next ? number - next : 0;
      // The first sample that arrives after a match may have any number.
      const bool is_first = next == 1 && known->number_of_changes_from_writer() == 0;
      if (ahead > kMostStored && !is_first) return false;
      if (ahead > 0 && sample->serializedPayload.length > largest_sample(*this, *mp_history)) return refuse();
    }
  }
  return receive(*this, [&] { return originals().data(this, sample); });
}

bool StatefulReader::processDataFragMsg(CacheChange_t* part, std::uint32_t sample, std::uint32_t first,
                                        std::uint16_t count) {
  const bool is_whole = first == 1 && std::uint64_t{count} * part->getFragmentSize() >= sample;
  // Fast DDS would store the incomplete sample under the key of this hash, and not remove it there when it
  // drops the sample. It computes the key when the sample is complete.
  part->instanceHandle = InstanceHandle_t{};
  std::unique_lock storing{storing_fragments};
  {
    const std::lock_guard lock{mp_mutex};
    WriterProxy* known = nullptr;
    if (!is_alive_ || !acceptMsgFrom(part->writerGUID, &known) || known == nullptr) return false;
    if (!is_acceptable(*this, *mp_history, *part, sample, first, count)) return refuse();
    if (fixed_payload_size_ > 0 && assembly_size(*part, sample) > fixed_payload_size_) return refuse();
    if (part->sequenceNumber.to64long() - known->available_changes_max().to64long() > kMostStored)
      return false;
    CacheChange_t* begun = nullptr;
    const bool is_stored = mp_history->get_change(part->sequenceNumber, part->writerGUID, &begun);
    if (!is_stored && !is_whole && !make_room(*mp_history, *part)) return refuse();
    if (is_stored && !begun->is_fully_assembled() && !continues(*begun, *part, sample)) {
      refuse();
      forget(*mp_history, *begun);
    }
  }
  if (!is_whole)
    return receive(*this, [&] { return originals().fragments(this, part, sample, first, count); });
  // Fast DDS would handle this sample twice: when it stores the first fragment, and when no fragment is
  // missing. The second time, the sample may already be gone.
  storing.unlock();
  CacheChange_t whole;
  whole.copy_not_memcpy(part);
  whole.setFragmentSize(0);
  whole.serializedPayload.data = part->serializedPayload.data;
  whole.serializedPayload.length = sample;
  whole.serializedPayload.max_size = sample;
  const bool is_taken = processDataMsg(&whole);
  // Fast DDS may have replaced the bytes of the packet by a copy that readers share.
  if (whole.payload_owner() != nullptr) whole.payload_owner()->release_payload(whole);
  whole.serializedPayload.data = nullptr;
  return is_taken;
}

// Finds the sample with this number, or else the one with the next larger number. Fast DDS assumes that the
// samples of a writer are stored in the order of their numbers. But it compares those of two writers by their
// times, so that the order is wrong after the clock of a writer was set back while its samples waited. Then
// Fast DDS would not count a sample as new, but let the listener take it, and with the next sample of its
// key, an assertion would end the process.
History::const_iterator History::get_change_nts(const SequenceNumber_t& number, const GUID_t& writer,
                                                CacheChange_t** sample, const_iterator hint) const {
  *sample = nullptr;
  const_iterator best = m_changes.end();
  for (const auto& [begin, end] : {std::pair{hint, m_changes.end()}, std::pair{m_changes.begin(), hint}}) {
    for (const_iterator each = begin; each != end; ++each) {
      if ((*each)->writerGUID != writer || (*each)->sequenceNumber < number) continue;
      if ((*each)->sequenceNumber == number) {
        *sample = *each;
        return each;
      }
      if (best == m_changes.end() || (*each)->sequenceNumber < (*best)->sequenceNumber) best = each;
    }
  }
  return best;
}

// Adds a sample. The reader may have fragments of another sample with the same number. Fast DDS would confuse
// the two, and an assertion would end the process.
bool ReaderHistory::add_change(CacheChange_t* sample) {
  if (mp_mutex != nullptr) {
    const std::lock_guard lock{*mp_mutex};
    CacheChange_t* begun = nullptr;
    if (get_change(sample->sequenceNumber, sample->writerGUID, &begun) && !begun->is_fully_assembled())
      forget(*this, *begun);
  }
  return originals().add(this, sample);
}

bool StatelessReader::processDataFragMsg(CacheChange_t* part, std::uint32_t sample, std::uint32_t first,
                                         std::uint16_t count) {
  part->instanceHandle = InstanceHandle_t{};  // see StatefulReader::processDataFragMsg()
  const std::lock_guard storing{storing_fragments};
  {
    const std::lock_guard lock{mp_mutex};
    for (RemoteWriterInfo_t& writer : matched_writers_) {
      CacheChange_t*& begun = writer.fragmented_change;
      if (writer.guid != part->writerGUID) continue;
      if (!is_acceptable(*this, *mp_history, *part, sample, first, count)) return refuse();
      if (fixed_payload_size_ > 0 && assembly_size(*part, sample) > fixed_payload_size_) return refuse();
      if (begun == nullptr) continue;
      if (begun->sequenceNumber == part->sequenceNumber && !continues(*begun, *part, sample)) return refuse();
      // Each copy of an authentication message has a new number, and Fast DDS would drop the fragments of the
      // copy before. On a network that loses packets, all fragments of one copy rarely arrive.
      if (m_guid.entityId == participant_stateless_message_reader_entity_id &&
          begun->sequenceNumber < part->sequenceNumber && continues(*begun, *part, sample))
        begun->sequenceNumber = part->sequenceNumber;
      // Fast DDS reuses the memory of an older sample if the new sample fits, but does not count kBehind.
      if (begun->sequenceNumber < part->sequenceNumber &&
          begun->serializedPayload.max_size < assembly_size(*part, sample)) {
        releaseCache(begun);
        begun = nullptr;
      }
    }
  }
  return originals().best_effort_fragments(this, part, sample, first, count);
}

// Reserves memory for a sample and for the kBehind bytes behind it.
bool RTPSReader::reserveCache(CacheChange_t** change, std::uint32_t size) {
  return originals().reserve(this, change, size + kBehind);
}

}  // namespace eprosima::fastrtps::rtps

namespace eprosima::fastdds::dds::detail {

// Adds a sample to those of its key, of which the reader keeps a limited number. If a sample is older than
// all of them, Fast DDS counts it as received and does not store it, but never frees it.
bool DataReaderHistory::received_change_keep_last(fastrtps::rtps::CacheChange_t* sample, std::size_t missing,
                                                  SampleRejectedStatusKind& why) {
  const bool is_received = originals().receive(this, sample, missing, why);
  if (is_received && find_change_nts(sample) == changesEnd()) too_old = sample;
  return is_received;
}

// Adds a sample of which the last fragment has arrived. It is already in the history, but not under its key.
// If Fast DDS drops it as too old, it would stay in the history. So it is added like a sample without
// fragments.
bool DataReaderHistory::completed_change_keep_last(fastrtps::rtps::CacheChange_t* sample, DataReaderInstance&,
                                                   std::size_t missing, SampleRejectedStatusKind& why) {
  History::remove_change_nts(find_change_nts(sample), false);
  const bool is_received = received_change_keep_last(sample, missing, why);
  if (!is_received) too_old = sample;
  return is_received;
}

}  // namespace eprosima::fastdds::dds::detail

namespace eprosima::fastdds::dds {

// Presents a sample to the listener. An incomplete sample comes this far if the list of a GAP contains its
// number. Then an assertion would end the process.
bool DataReaderImpl::on_new_cache_change_added(const fastrtps::rtps::CacheChange_t* sample) {
  auto& stored = const_cast<fastrtps::rtps::CacheChange_t&>(*sample);
  if (stored.is_fully_assembled()) return originals().present(this, sample);
  forget(*notifying.history, stored);
  return refuse();
}

}  // namespace eprosima::fastdds::dds

namespace eprosima::fastrtps::rtps::security {

// Handles an authentication message. Fast DDS may have assembled it from fragments, which nobody has checked.
void SecurityManager::process_participant_stateless_message(const CacheChange_t* message) {
  const SerializedPayload_t& content = message->serializedPayload;
  if (takt::wire::is_readable_proof({content.data, content.length}, &takt::security::names_somebody))
    originals().authenticate(this, message);
}

}  // namespace eprosima::fastrtps::rtps::security
