#include "reader_checks.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include <takt/security/identity.hpp>
#include <takt/wire/rtps.hpp>
#include "replaced_function.hpp"

// The mangled names of the functions of Fast DDS. SAMPLE is the end of "pointer to a sample" in them.
#if TAKT_FASTDDS == 2
#include <fastdds/rtps/history/ReaderHistory.h>
#include <fastdds/rtps/reader/RTPSReader.h>
#define DATA TAKT_RTPS "14StatefulReader14processDataMsgEPNS1_13CacheChange_tE"
#define FRAGMENTS TAKT_RTPS "14StatefulReader18processDataFragMsgEPNS1_13CacheChange_tEjjt"
#define BEST_EFFORT_FRAGMENTS TAKT_RTPS "15StatelessReader18processDataFragMsgEPNS1_13CacheChange_tEjjt"
#define GAP TAKT_RTPS "14StatefulReader13processGapMsgE"
#define RESERVE TAKT_RTPS "10RTPSReader12reserveCacheEPPNS1_13CacheChange_tEj"
#define RELEASE TAKT_RTPS "10RTPSReader12releaseCacheEPNS1_13CacheChange_tE"
#define SAMPLE "NS_8fastrtps4rtps13CacheChange_tE"
#else
#include <fastdds/rtps/history/ReaderHistory.hpp>
#include <fastdds/rtps/reader/RTPSReader.hpp>
#define DATA TAKT_RTPS "14StatefulReader16process_data_msgEPNS1_13CacheChange_tE"
#define FRAGMENTS TAKT_RTPS "14StatefulReader21process_data_frag_msgEPNS1_13CacheChange_tEjjt"
#define BEST_EFFORT_FRAGMENTS TAKT_RTPS "15StatelessReader21process_data_frag_msgEPNS1_13CacheChange_tEjjt"
#define GAP TAKT_RTPS "14StatefulReader15process_gap_msgE"
#define RESERVE TAKT_RTPS "10BaseReader13reserve_cacheEjRPNS1_13CacheChange_tE"
#define RELEASE TAKT_RTPS "10BaseReader13release_cacheEPNS1_13CacheChange_tE"
#define HANDLED TAKT_RTPS "10BaseReader20update_last_notifiedERKNS1_6GUID_tERKNS1_16SequenceNumber_tE"
#define SAMPLE "NS0_4rtps13CacheChange_tE"
#endif
#define GAP_OF                                                             \
  GAP "RKNS1_6GUID_tERKNS1_16SequenceNumber_tERKNS0_11BitmapRangeIS6_NS1_" \
      "18SequenceNumberDiffELj256EEE" TAKT_VENDOR
#define NEXT TAKT_RTPS "11WriterProxy32next_cache_change_to_be_notifiedEv"
#define NOTIFY TAKT_RTPS "14StatefulReader13NotifyChangesEPNS1_11WriterProxyE"
#define ADD TAKT_RTPS "13ReaderHistory10add_changeEPNS1_13CacheChange_tE"
#define AUTHENTICATE \
  TAKT_RTPS "8security15SecurityManager37process_participant_stateless_messageEPKNS1_13CacheChange_tE"
#define RECEIVE                                                             \
  TAKT_DDS "6detail17DataReaderHistory25received_change_keep_lastEP" SAMPLE \
           "mRNS1_24SampleRejectedStatusKindE"
#define COMPLETE                                                             \
  TAKT_DDS "6detail17DataReaderHistory26completed_change_keep_lastEP" SAMPLE \
           "RNS2_18DataReaderInstance"                                       \
           "EmRNS1_24SampleRejectedStatusKindE"
#define PRESENT TAKT_DDS "14DataReaderImpl25on_new_cache_change_addedEPK" SAMPLE

namespace takt::dds {

namespace {

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
constexpr std::uint32_t kAuthenticationReader =
    0x000201c4;  // entity id of the reader of authentication messages

// What a reader knows about a writer: a WriterProxy of Fast DDS. A "number" in this file is a sequence
// number.
using Known = void;

/// The replaced functions of Fast DDS, and others that it does not declare for everybody.
struct Functions {
  using Data = bool(rtps::RTPSReader*, rtps::CacheChange_t*);
  using Fragments = bool(rtps::RTPSReader*, rtps::CacheChange_t*, std::uint32_t, std::uint32_t,
                         std::uint16_t);
#if TAKT_FASTDDS == 2
  using Gap = bool(rtps::RTPSReader*, const rtps::GUID_t&, const rtps::SequenceNumber_t&,
                   const rtps::SequenceNumberSet_t&);
  using Reserve = bool(rtps::RTPSReader*, rtps::CacheChange_t**, std::uint32_t);
#else
  using Gap = bool(rtps::RTPSReader*, const rtps::GUID_t&, const rtps::SequenceNumber_t&,
                   const rtps::SequenceNumberSet_t&, std::array<std::uint8_t, 2>);
  using Reserve = bool(rtps::RTPSReader*, std::uint32_t, rtps::CacheChange_t*&);
  using Handled = rtps::SequenceNumber_t(rtps::RTPSReader*, const rtps::GUID_t&,
                                         const rtps::SequenceNumber_t&);
  Handled* handled = replaced<Handled>(HANDLED);
#endif
  using Release = void(rtps::RTPSReader*, rtps::CacheChange_t*);
  using Next = rtps::SequenceNumber_t(Known*);
  using Notify = void(rtps::RTPSReader*, Known*);
  using Add = bool(rtps::ReaderHistory*, rtps::CacheChange_t*);
  using Receive = bool(rtps::ReaderHistory*, rtps::CacheChange_t*, std::size_t, void*);
  using Present = bool(void*, const rtps::CacheChange_t*);
  using Authenticate = void(void*, const rtps::CacheChange_t*);
  // Not replaced:
  using Accepts = bool(const rtps::RTPSReader*, const rtps::GUID_t&, Known**);
  using Lookup = bool(rtps::RTPSReader*, const rtps::GUID_t&, Known**);
  using Last = rtps::SequenceNumber_t(const Known*);
  using Count = std::size_t(const Known*);
  using Set = void(Known*, const rtps::SequenceNumber_t&);
  using Lose = std::int32_t(Known*, const rtps::SequenceNumber_t&);

  Data* data = replaced<Data>(DATA);
  Fragments* fragments = replaced<Fragments>(FRAGMENTS);
  Fragments* best_effort_fragments = replaced<Fragments>(BEST_EFFORT_FRAGMENTS);
  Gap* gap = replaced<Gap>(GAP_OF);
  Reserve* reserve = replaced<Reserve>(RESERVE);
  Next* next = replaced<Next>(NEXT);
  Notify* notify = replaced<Notify>(NOTIFY);
  Add* add = replaced<Add>(ADD);
  Receive* receive = replaced<Receive>(RECEIVE);
  Present* present = replaced<Present>(PRESENT);
  Authenticate* authenticate = replaced<Authenticate>(AUTHENTICATE);
  /// Frees a sample.
  Release* release = replaced<Release>(RELEASE);
  /// Returns true if the reader accepts messages of this writer. Sets what the reader knows about it, or null
  /// if the reader accepts messages of all writers.
  Accepts* accepts =
      replaced<Accepts>(TAKT_RTPS_CONST "14StatefulReader13acceptMsgFromERKNS1_6GUID_tEPPNS1_11WriterProxyE");
  /// Sets what the reader knows about a writer; returns false if it knows nothing.
  Lookup* lookup = replaced<Lookup>(
      TAKT_RTPS "14StatefulReader21matched_writer_lookupERKNS1_6GUID_tEPPNS1_11WriterProxyE");
  /// Returns a number: all up to this one are received or lost.
  Last* last = replaced<Last>(TAKT_RTPS_CONST "11WriterProxy21available_changes_maxEv");
  /// Returns how many later numbers the writer has used.
  Count* later = replaced<Count>(TAKT_RTPS_CONST "11WriterProxy29number_of_changes_from_writerEv");
  /// All numbers up to this one are received, and no later one is known.
  Set* set_last = replaced<Set>(TAKT_RTPS "11WriterProxy19loaded_from_storageERKNS1_16SequenceNumber_tE");
  /// The numbers before this one are lost.
  Lose* lose = replaced<Lose>(TAKT_RTPS "11WriterProxy19lost_changes_updateERKNS1_16SequenceNumber_tE");
  /// The numbers up to this one exist.
  Set* expect = replaced<Set>(TAKT_RTPS "11WriterProxy22missing_changes_updateERKNS1_16SequenceNumber_tE");
};

const Functions& functions() noexcept {
  static const Functions found;
  return found;
}

rtps::ReaderHistory& history_of(rtps::RTPSReader& reader) {
#if TAKT_FASTDDS == 2
  return *reader.getHistory();
#else
  return *reader.get_history();
#endif
}

std::atomic<std::uint64_t> refused{0};

/// Counts a packet that a reader ignores, and returns false.
bool refuse() noexcept {
  refused.fetch_add(1, std::memory_order_relaxed);
  return false;
}

/// Returns the largest size of a sample in fragments that this reader accepts, in bytes. A reader of Takt
/// knows the largest sample of its type.
std::uint32_t largest_sample(rtps::RTPSReader& reader) {
  return reader.getGuid().is_builtin() ? kMostPayload : history_of(reader).getTypeMaxSerialized();
}

/// Returns the number of bytes in which Fast DDS assembles a sample.
std::uint64_t assembly_size(const rtps::CacheChange_t& part, std::uint32_t sample) {
  const std::uint64_t last = std::uint64_t{sample - 1} / part.getFragmentSize() * part.getFragmentSize();
  return std::max<std::uint64_t>(sample, (last + 3) / 4 * 4 + kIndex);
}

/// Returns true if a DATA_FRAG contains the fragments that it claims to contain, and the reader accepts such
/// a long sample.
bool is_acceptable(rtps::RTPSReader& reader, const rtps::CacheChange_t& part, std::uint32_t sample,
                   std::uint32_t first, std::uint32_t count) {
  const std::uint64_t size = part.getFragmentSize();
  if (size < kIndex || sample > largest_sample(reader) || first == 0 || count == 0) return false;
  const std::uint64_t begin = (first - 1) * size;
  if (begin + (count - 1) * size >= sample) return false;
  const std::uint32_t length = part.serializedPayload.length;
  if (length > kMostPayload || length < std::min(count * size, sample - begin)) return false;
  const rtps::HistoryAttributes& memory = history_of(reader).m_att;
  return memory.memoryPolicy != rtps::PREALLOCATED_MEMORY_MODE ||
         assembly_size(part, sample) <= memory.payloadMaxSize;
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
  if (rtps::CacheChange_t* const dropped = std::exchange(too_old, outer))
    functions().release(&reader, dropped);
  return is_taken;
}

// The reader that passes samples to its listener on this thread.
thread_local rtps::RTPSReader* notifying = nullptr;

// Locked from the comparison with the first DATA_FRAG until the fragments are stored. The lock of the reader
// cannot be held so long, because Fast DDS needs to release it in between.
std::mutex storing_fragments;

/// The sample of a writer that a best-effort reader assembles.
struct Begun {
  rtps::SequenceNumber_t number;  // the one that Fast DDS knows
  rtps::SequenceNumber_t newest;  // of a later copy of the same authentication message
  std::uint32_t size = 0;
  std::uint16_t fragment_size = 0;
  std::uint32_t missing = 0;
  std::vector<bool> has;  // by fragment
};
// Readers and writers that have ended leave theirs behind. If there are so many, all are forgotten.
constexpr std::size_t kMostAssembled = 4096;
std::map<std::pair<const rtps::RTPSReader*, rtps::GUID_t>, Begun> all_begun;

/// What to do with fragments for a best-effort reader.
enum class Fragments { take, ignore, refuse };

/// Notes acceptable fragments for a best-effort reader. Each copy of an authentication message has a new
/// number, and Fast DDS would drop the fragments of the copy before; on a network that loses packets, all
/// fragments of one copy rarely arrive. So all copies get the number of the first one.
Fragments note(const rtps::RTPSReader& reader, rtps::CacheChange_t& part, std::uint32_t sample,
               std::uint32_t first, std::uint32_t count) {
  if (all_begun.size() >= kMostAssembled) all_begun.clear();
  Begun& begun = all_begun[{&reader, part.writerGUID}];
  const bool continues = begun.size == sample && begun.fragment_size == part.getFragmentSize();
  const bool is_authentication = reader.getGuid().entityId == rtps::EntityId_t{kAuthenticationReader};
  if (part.sequenceNumber <= begun.newest) {
    if (begun.missing == 0 || part.sequenceNumber < begun.number) return Fragments::ignore;
    if (!continues) return Fragments::refuse;
  } else if (is_authentication && continues && begun.missing > 0) {
    begun.newest = part.sequenceNumber;
  } else {
    begun.number = begun.newest = part.sequenceNumber;
    begun.size = sample;
    begun.fragment_size = part.getFragmentSize();
    begun.missing = (sample + begun.fragment_size - 1) / begun.fragment_size;
    begun.has.assign(begun.missing, false);
  }
  part.sequenceNumber = begun.number;
  for (std::uint32_t each = first - 1; each < first - 1 + count && each < begun.has.size(); ++each) {
    if (!begun.has[each]) --begun.missing;
    begun.has[each] = true;
  }
  return Fragments::take;
}

}  // namespace

void check_what_readers_receive() noexcept { static_cast<void>(functions()); }

std::uint64_t refused_by_readers() noexcept { return refused.load(std::memory_order_relaxed); }

rtps::SequenceNumber_t next_to_notify(Known* known) asm(NEXT);
void notify_changes(rtps::RTPSReader* reader, Known* known) asm(NOTIFY);
bool process_data(rtps::RTPSReader* reader, rtps::CacheChange_t* sample) asm(DATA);
bool process_fragments(rtps::RTPSReader* reader, rtps::CacheChange_t* part, std::uint32_t sample,
                       std::uint32_t first, std::uint16_t count) asm(FRAGMENTS);
bool process_best_effort_fragments(rtps::RTPSReader* reader, rtps::CacheChange_t* part, std::uint32_t sample,
                                   std::uint32_t first, std::uint16_t count) asm(BEST_EFFORT_FRAGMENTS);
bool add_sample(rtps::ReaderHistory* samples, rtps::CacheChange_t* sample) asm(ADD);
bool receive_sample(rtps::ReaderHistory* samples, rtps::CacheChange_t* sample, std::size_t missing,
                    void* why) asm(RECEIVE);
bool complete_sample(rtps::ReaderHistory* samples, rtps::CacheChange_t* sample, void* same_key,
                     std::size_t missing, void* why) asm(COMPLETE);
bool present_sample(void* reader, const rtps::CacheChange_t* sample) asm(PRESENT);
void authenticate(void* manager, const rtps::CacheChange_t* message) asm(AUTHENTICATE);

// Returns the next number that the reader passes to its listener, if there is a sample with this number.
rtps::SequenceNumber_t next_to_notify(Known* known) {
  const rtps::SequenceNumber_t next = functions().next(known);
  const rtps::SequenceNumber_t last = functions().last(known);
  if (next == rtps::c_SequenceNumber_Unknown || last.to64long() - next.to64long() < kMostCounted) return next;
  // A sample with a skipped number may have been waiting. Fast DDS would not count it, but let the listener
  // take it, and with the next sample of its key, an assertion would end the process.
  forget(history_of(*notifying), [&](rtps::CacheChange_t& each) {
    Known* its = nullptr;
    return next <= each.sequenceNumber && each.sequenceNumber <= last - kMostCounted &&
           functions().lookup(notifying, each.writerGUID, &its) && its == known;
  });
  const auto used = static_cast<std::uint32_t>(functions().later(known));
  functions().set_last(known, last - kMostCounted);
  functions().lose(known, last + 1);
  functions().expect(known, last + used);
  return functions().next(known);
}

void notify_changes(rtps::RTPSReader* reader, Known* known) {
  rtps::RTPSReader* const outer = std::exchange(notifying, reader);
  functions().notify(reader, known);
  notifying = outer;
}

/// Makes a GAP short, and lets `handle` pass it to Fast DDS.
template <class Handle>
bool check_gap(rtps::RTPSReader& reader, const rtps::GUID_t& writer, const rtps::SequenceNumber_t& start,
               const rtps::SequenceNumberSet_t& list, Handle&& handle) {
  const std::lock_guard lock{reader.getMutex()};
  Known* known = nullptr;
  if (!functions().accepts(&reader, writer, &known) || known == nullptr) return false;
  // Fast DDS would free an incomplete sample that the GAP skips, but leave it among those of its key.
  forget(history_of(reader), [&](rtps::CacheChange_t& each) {
    return each.writerGUID == writer && !each.is_fully_assembled() && start <= each.sequenceNumber &&
           (each.sequenceNumber < list.base() || list.is_set(each.sequenceNumber));
  });
  const rtps::SequenceNumber_t next = functions().last(known) + 1;
  const rtps::SequenceNumber_t end = list.base();
  if (start <= next && start < end) {
    functions().lose(known, end);
    return handle(end - 1, list);
  }
  const rtps::SequenceNumber_t limit = next + kMostStored;
  return handle(start, end > limit ? rtps::SequenceNumberSet_t{limit} : list);
}

#if TAKT_FASTDDS == 2
bool process_gap(rtps::RTPSReader* reader, const rtps::GUID_t& writer, const rtps::SequenceNumber_t& start,
                 const rtps::SequenceNumberSet_t& list) asm(GAP_OF);
bool process_gap(rtps::RTPSReader* reader, const rtps::GUID_t& writer, const rtps::SequenceNumber_t& start,
                 const rtps::SequenceNumberSet_t& list) {
  return check_gap(*reader, writer, start, list, [&](const auto& from, const auto& numbers) {
    return functions().gap(reader, writer, from, numbers);
  });
}
bool reserve(rtps::RTPSReader* reader, rtps::CacheChange_t** made, std::uint32_t size) asm(RESERVE);
#else
bool process_gap(rtps::RTPSReader* reader, const rtps::GUID_t& writer, const rtps::SequenceNumber_t& start,
                 const rtps::SequenceNumberSet_t& list, std::array<std::uint8_t, 2> vendor) asm(GAP_OF);
bool process_gap(rtps::RTPSReader* reader, const rtps::GUID_t& writer, const rtps::SequenceNumber_t& start,
                 const rtps::SequenceNumberSet_t& list, std::array<std::uint8_t, 2> vendor) {
  return check_gap(*reader, writer, start, list, [&](const auto& from, const auto& numbers) {
    return functions().gap(reader, writer, from, numbers, vendor);
  });
}
bool reserve(rtps::RTPSReader* reader, std::uint32_t size, rtps::CacheChange_t*& made) asm(RESERVE);

// Notes that the samples of a writer up to this number are handled, and returns the last number before, from
// which Fast DDS counts lost samples. When a best-effort reader gives up a sample of which fragments are
// missing, it may have received later ones. Then an assertion would end the process; 0 means that no sample
// counts as lost.
rtps::SequenceNumber_t note_handled(rtps::RTPSReader* reader, const rtps::GUID_t& writer,
                                    const rtps::SequenceNumber_t& number) asm(HANDLED);
rtps::SequenceNumber_t note_handled(rtps::RTPSReader* reader, const rtps::GUID_t& writer,
                                    const rtps::SequenceNumber_t& number) {
  const rtps::SequenceNumber_t before = functions().handled(reader, writer, number);
  return before < number ? before : rtps::SequenceNumber_t{};
}
#endif

bool process_data(rtps::RTPSReader* reader, rtps::CacheChange_t* sample) {
  {
    const std::lock_guard lock{reader->getMutex()};
    Known* known = nullptr;
    if (!functions().accepts(reader, sample->writerGUID, &known)) return false;
    // A sample that must wait for earlier ones is stored. It may be as long as its packet, which is much
    // longer than most types allow.
    if (known != nullptr) {
      const std::uint64_t next = functions().last(known).to64long() + 1;
      const std::uint64_t number = sample->sequenceNumber.to64long();
      const std::uint64_t ahead = number > next ? number - next : 0;
      // The first sample that arrives after a match may have any number.
      const bool is_first = next == 1 && functions().later(known) == 0;
      if (ahead > kMostStored && !is_first) return false;
      if (ahead > 0 && sample->serializedPayload.length > largest_sample(*reader)) return refuse();
    }
  }
  return receive(*reader, [&] { return functions().data(reader, sample); });
}

bool process_fragments(rtps::RTPSReader* reader, rtps::CacheChange_t* part, std::uint32_t sample,
                       std::uint32_t first, std::uint16_t count) {
  const bool is_whole = first == 1 && std::uint64_t{count} * part->getFragmentSize() >= sample;
  // Fast DDS would store the incomplete sample under the key of this hash, and not remove it there when it
  // drops the sample. It computes the key when the sample is complete.
  part->instanceHandle = rtps::InstanceHandle_t{};
  std::unique_lock storing{storing_fragments};
  {
    const std::lock_guard lock{reader->getMutex()};
    Known* known = nullptr;
    if (!functions().accepts(reader, part->writerGUID, &known) || known == nullptr) return false;
    if (!is_acceptable(*reader, *part, sample, first, count)) return refuse();
    if (part->sequenceNumber.to64long() - functions().last(known).to64long() > kMostStored) return false;
    rtps::ReaderHistory& samples = history_of(*reader);
    rtps::CacheChange_t* begun = nullptr;
    const bool is_stored = samples.get_change(part->sequenceNumber, part->writerGUID, &begun);
    if (!is_stored && !is_whole && !make_room(samples, *part)) return refuse();
    if (is_stored && !begun->is_fully_assembled() && !continues(*begun, *part, sample)) {
      refuse();
      forget(samples, *begun);
    }
  }
  if (!is_whole)
    return receive(*reader, [&] { return functions().fragments(reader, part, sample, first, count); });
  // Fast DDS would handle this sample twice: when it stores the first fragment, and when no fragment is
  // missing. The second time, the sample may already be gone.
  storing.unlock();
  rtps::CacheChange_t whole;
  whole.copy_not_memcpy(part);
  whole.setFragmentSize(0);
  whole.serializedPayload.data = part->serializedPayload.data;
  whole.serializedPayload.length = sample;
  whole.serializedPayload.max_size = sample;
  const bool is_taken = process_data(reader, &whole);
  // Fast DDS may have replaced the bytes of the packet by a copy that readers share.
#if TAKT_FASTDDS == 2
  if (whole.payload_owner() != nullptr) whole.payload_owner()->release_payload(whole);
#else
  if (rtps::IPayloadPool* const pool = whole.serializedPayload.payload_owner)
    pool->release_payload(whole.serializedPayload);
#endif
  whole.serializedPayload.data = nullptr;
  return is_taken;
}

bool process_best_effort_fragments(rtps::RTPSReader* reader, rtps::CacheChange_t* part, std::uint32_t sample,
                                   std::uint32_t first, std::uint16_t count) {
  part->instanceHandle = rtps::InstanceHandle_t{};  // see process_fragments()
  const std::lock_guard storing{storing_fragments};
  if (reader->matched_writer_is_matched(part->writerGUID)) {
    if (!is_acceptable(*reader, *part, sample, first, count)) return refuse();
    const Fragments noted = note(*reader, *part, sample, first, count);
    if (noted == Fragments::ignore) return true;
    if (noted == Fragments::refuse) return refuse();
  }
  return functions().best_effort_fragments(reader, part, sample, first, count);
}

// Reserves memory for a sample and for the kBehind bytes behind it, which Fast DDS must not use for a later
// sample.
#if TAKT_FASTDDS == 2
bool reserve(rtps::RTPSReader* reader, rtps::CacheChange_t** made, std::uint32_t size) {
  if (!functions().reserve(reader, made, size + kBehind)) return false;
  std::uint32_t& available = (*made)->serializedPayload.max_size;
#else
bool reserve(rtps::RTPSReader* reader, std::uint32_t size, rtps::CacheChange_t*& made) {
  if (!functions().reserve(reader, size + kBehind, made)) return false;
  std::uint32_t& available = made->serializedPayload.max_size;
#endif
  if (available >= size + kBehind) available -= kBehind;
  return true;
}

// Adds a sample. The reader may have fragments of another sample with the same number. Fast DDS would confuse
// the two, and an assertion would end the process.
bool add_sample(rtps::ReaderHistory* samples, rtps::CacheChange_t* sample) {
  if (samples->getMutex() != nullptr) {
    const std::lock_guard lock{*samples->getMutex()};
    rtps::CacheChange_t* begun = nullptr;
    if (samples->get_change(sample->sequenceNumber, sample->writerGUID, &begun) &&
        !begun->is_fully_assembled())
      forget(*samples, *begun);
  }
  return functions().add(samples, sample);
}

// Adds a sample to those of its key, of which the reader keeps a limited number. If a sample is older than
// all of them, Fast DDS counts it as received and does not store it, but never frees it.
bool receive_sample(rtps::ReaderHistory* samples, rtps::CacheChange_t* sample, std::size_t missing,
                    void* why) {
  const bool is_received = functions().receive(samples, sample, missing, why);
  if (is_received && samples->find_change_nts(sample) == samples->changesEnd()) too_old = sample;
  return is_received;
}

// Adds a sample of which the last fragment has arrived. It is already in the history, but not under its key.
// If Fast DDS drops it as too old, it would stay in the history. So it is added like a sample without
// fragments.
bool complete_sample(rtps::ReaderHistory* samples, rtps::CacheChange_t* sample, void*, std::size_t missing,
                     void* why) {
  samples->rtps::History::remove_change_nts(samples->find_change_nts(sample), false);
  const bool is_received = receive_sample(samples, sample, missing, why);
  if (!is_received) too_old = sample;
  return is_received;
}

// Presents a sample to the listener. An incomplete sample comes this far if the list of a GAP contains its
// number. Then an assertion would end the process.
bool present_sample(void* reader, const rtps::CacheChange_t* sample) {
  auto& stored = const_cast<rtps::CacheChange_t&>(*sample);
  if (stored.is_fully_assembled()) return functions().present(reader, sample);
  forget(history_of(*notifying), stored);
  return refuse();
}

// Handles an authentication message. Fast DDS may have assembled it from fragments, which nobody has checked.
void authenticate(void* manager, const rtps::CacheChange_t* message) {
  const rtps::SerializedPayload_t& content = message->serializedPayload;
  if (wire::is_readable_proof({content.data, content.length}, &security::names_somebody))
    functions().authenticate(manager, message);
}

}  // namespace takt::dds

// Finds the sample with this number, or else the one with the next larger number. Fast DDS assumes that the
// samples of a writer are stored in the order of their numbers. But it compares those of two writers by their
// times, so that the order is wrong after the clock of a writer was set back while its samples waited. Then
// Fast DDS would not count a sample as new, but let the listener take it, and with the next sample of its
// key, an assertion would end the process.
takt::dds::rtps::History::const_iterator takt::dds::rtps::History::get_change_nts(
    const SequenceNumber_t& number, const GUID_t& writer, CacheChange_t** sample, const_iterator hint) const {
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
