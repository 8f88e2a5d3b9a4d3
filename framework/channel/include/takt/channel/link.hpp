// A link: the shared memory of one connection. It passes samples from one writer to one reader, in different
// threads or processes.
//
// When the queue is full, the writer drops the oldest sample, so both writer and reader change the queue. A
// process could be killed while it holds a lock, so a link uses no lock. Every sample is in a buffer, and
// writer and reader pass each other only buffer numbers. There are depth + 2 buffers: one in each slot, one
// private to the writer, and one private to the reader. The writer fills its own buffer and exchanges this
// buffer for the one in the next slot. The reader exchanges its own buffer for the oldest full one. Only the
// side that has a buffer's number accesses the buffer, so the reader never sees a half-written sample. With
// depth 1, the link holds only the latest value.
//
// Each side (writer or reader) announces which buffer it has, and which buffer it is about to take for which
// sample. If a side dies during an exchange, its successor finds from these announcements, in a few steps,
// which buffer the dead side had. The other side may continue meanwhile.
//
// The node can force the reader of a link with room for a forced value: the reader then uses this value
// instead of the samples, which the writer keeps writing and the reader keeps taking.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <takt/core/check.hpp>

namespace takt::channel {

/// The metadata of a sample.
struct SampleInfo {
  std::uint64_t sequence = 0;  ///< number of the sample; the writer of the link counts from 1 without gaps
  std::int64_t stamp_ns = 0;   ///< monotonic time at which the run() that wrote the sample began
  std::uint32_t size = 0;      ///< size of the payload, in bytes
  std::int64_t valid_ns = 0;   ///< monotonic time from which the sample may be read; 0: at once
};

/// The word of a slot has three parts: a bit that is set if the slot is full, the number of the slot's
/// sample, and the number of its buffer. An emptied slot keeps the number of the sample that was taken from
/// it. So the words alone show how far writer and reader have come.
struct SlotWord {
  static constexpr std::uint64_t kFull = std::uint64_t{1} << 63;
  static constexpr unsigned kIndexBits = 18;

  static constexpr std::uint64_t make(bool full, std::uint64_t sequence, std::uint32_t index) noexcept {
    return (full ? kFull : 0) | (sequence << kIndexBits) | index;
  }
  static constexpr bool full(std::uint64_t word) noexcept { return (word & kFull) != 0; }
  static constexpr std::uint64_t sequence(std::uint64_t word) noexcept {
    return (word & ~kFull) >> kIndexBits;
  }
  static constexpr std::uint32_t index(std::uint64_t word) noexcept {
    return static_cast<std::uint32_t>(word & ((1U << kIndexBits) - 1));
  }
};

inline constexpr std::uint32_t kMaxLinkDepth = 65536;
/// Value of BasicLinkBlock::trusted_from: no sample is trusted.
inline constexpr std::uint64_t kNobody = std::numeric_limits<std::uint64_t>::max();
/// A time that never comes.
inline constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

/// The start of a link's memory; slots, sample infos and payloads follow. The memory contains no pointers.
/// `Atomic` is std::atomic, except in a test that interrupts the code between any two accesses.
template <template <class> class Atomic>
struct alignas(64) BasicLinkBlock {
  static constexpr std::uint64_t kMagic = 0x6b6e'696c'0000'0006;  // "link", layout 6

  // format() and the node set these fields before the link is used.
  std::uint64_t magic;
  std::uint32_t depth;      ///< number of slots, 1 to 65536; 1: the link holds only the latest value
  std::uint32_t stride;     ///< bytes reserved for one payload, a multiple of 64; 0: the payloads are C++
                            ///< objects in the host's memory
  std::uint32_t is_queue;   ///< 1: a sample that is overwritten before it is read counts as dropped
  std::uint32_t wake_bits;  ///< the bits of the wake word that wake the reader after a sample was written; 0:
                            ///< the reader does not sleep
  std::int64_t deadline_ns;       ///< a value older than this is stale; 0: values never become stale
  Atomic<std::uint32_t> enabled;  ///< 0: writers skip this link, because nobody reads it. Set by the node.
  std::uint32_t safe_room;        ///< bytes reserved for a safe value; 0: this link has none
  /// In a link with a safe value: the lowest number of a sample that the reader may get, or kNobody while the
  /// writer does not execute. The reader's node sets this word.
  Atomic<std::uint64_t> trusted_from;
  Atomic<std::uint32_t> safe_size;  ///< size of the safe value, in bytes; 0: not known yet. Stored after the
                                    ///< value's bytes
  std::uint32_t force_room;         ///< bytes reserved for a forced value; 0: the reader cannot be forced

  /// In a link for samples of another device: an upper limit for the difference between the wall clock of
  /// that device and the monotonic clock of this device; 0: not known. From this limit, the gateway
  /// calculates the maximum age of a sample. The reader's node sets this word.
  Atomic<std::int64_t> sender_clock_ns;

  // The writer writes these fields.
  alignas(64) Atomic<std::uint64_t> written;  ///< number of samples written so far
  Atomic<std::int64_t> newest_ns;             ///< stamp of the last sample; 0: none yet
  Atomic<std::uint64_t> overwritten;          ///< number of samples that were overwritten before they were
                                              ///< read
  Atomic<std::uint64_t> unfit;       ///< number of values that were not written because they do not fit their
                                     ///< type
  Atomic<std::uint32_t> writer_has;  ///< number of the writer's buffer
  Atomic<std::uint64_t>
      writer_takes;  ///< a SlotWord: which buffer the writer is taking, and for which sample

  // The reader writes these fields.
  alignas(64) Atomic<std::uint64_t> taken;
  Atomic<std::uint64_t> refused;  ///< number of samples that the reader took but rejected, because their
                                  ///< bytes are not valid for the type
  Atomic<std::uint64_t> late;     ///< number of times that the newest value was older than the deadline
  Atomic<std::uint64_t>
      reader_has;  ///< a SlotWord: the reader's buffer, and the last sample that the reader finished
  Atomic<std::uint64_t>
      reader_takes;  ///< a SlotWord: the sample that the reader is taking, and the sample's buffer
  Atomic<std::uint32_t> force_held;  ///< number of the force whose value the reader is decoding; 0: none

  // The node writes these fields. They lie here, because the reader needs this cache line for each sample.
  Atomic<std::uint32_t> forced;         ///< number of the present force; 0: the reader is not forced
  Atomic<std::uint32_t> force_size;     ///< size of the forced value, in bytes
  Atomic<std::int64_t> force_until_ns;  ///< monotonic time at which the reader ends the force by itself
};

/// A sample's info in the memory of a link. Two members are read while the writer may write them: `sequence`
/// by the successor of a reader, and `valid_ns` by a reader that checks whether it may take the sample.
template <template <class> class Atomic>
struct BasicSampleHead {
  Atomic<std::uint64_t> sequence;
  Atomic<std::int64_t> valid_ns;
  std::int64_t stamp_ns;
  std::uint32_t size;
};

/// The offsets of a link's parts from the start of its memory.
template <template <class> class Atomic>
class BasicLinkLayout {
 public:
  constexpr BasicLinkLayout(std::uint32_t depth, std::uint32_t stride, std::uint32_t safe = 0,
                            std::uint32_t force = 0) noexcept
      : depth_(depth), stride_(stride), safe_(safe), force_(force) {}
  [[nodiscard]] constexpr std::uint32_t depth() const noexcept { return depth_; }
  [[nodiscard]] constexpr std::uint32_t stride() const noexcept { return stride_; }
  [[nodiscard]] constexpr std::uint32_t buffers() const noexcept { return depth_ + 2; }
  [[nodiscard]] constexpr std::size_t slots() const noexcept { return sizeof(BasicLinkBlock<Atomic>); }
  [[nodiscard]] constexpr std::size_t heads() const noexcept {
    return up(slots() + std::size_t{depth_} * sizeof(Atomic<std::uint64_t>));
  }
  [[nodiscard]] constexpr std::size_t payloads() const noexcept {
    return up(heads() + std::size_t{buffers()} * sizeof(BasicSampleHead<Atomic>));
  }
  /// The offset of the safe value, behind the payloads.
  [[nodiscard]] constexpr std::size_t safe() const noexcept {
    return payloads() + std::size_t{buffers()} * stride_;
  }
  [[nodiscard]] constexpr std::uint32_t safe_room() const noexcept { return safe_; }
  /// The offset of the forced value, behind the safe value.
  [[nodiscard]] constexpr std::size_t force() const noexcept { return up(safe() + safe_); }
  [[nodiscard]] constexpr std::uint32_t force_room() const noexcept { return force_; }
  [[nodiscard]] constexpr std::size_t size() const noexcept { return up(force() + force_); }

 private:
  static constexpr std::size_t up(std::size_t n) noexcept { return (n + 63) / 64 * 64; }
  std::uint32_t depth_;
  std::uint32_t stride_;
  std::uint32_t safe_;
  std::uint32_t force_;
};

/// Access to a link's memory, for its writer and its reader. Copies of this object refer to the same memory.
template <template <class> class Atomic>
class BasicLink {
 public:
  using Block = BasicLinkBlock<Atomic>;
  using Head = BasicSampleHead<Atomic>;
  using Layout = BasicLinkLayout<Atomic>;

  BasicLink() = default;
  /// `memory`: a formatted link of Layout::size() bytes, aligned to 64 bytes. Depth and stride are read only
  /// here. So if a process that writes out of bounds changes them later, all accesses still stay within the
  /// memory.
  explicit BasicLink(std::byte* memory) noexcept
      : block_(reinterpret_cast<Block*>(memory)),
        layout_(block_->depth, block_->stride, block_->safe_room, block_->force_room) {
    slots_ = reinterpret_cast<Atomic<std::uint64_t>*>(memory + layout_.slots());
    heads_ = reinterpret_cast<Head*>(memory + layout_.heads());
    payloads_ = memory + layout_.payloads();
    safe_ = memory + layout_.safe();
    force_ = memory + layout_.force();
  }

  struct Options {
    std::uint32_t depth = 1;
    std::uint32_t payload = 0;  ///< maximum size of one sample, in bytes; 0: the payloads are C++ objects in
                                ///< the host's memory
    bool is_queue = false;
    std::uint32_t wake_bits = 0;
    std::int64_t deadline_ns = 0;
    bool enabled = true;
    std::uint32_t safe = 0;   ///< maximum size of the safe value, in bytes; 0: the link has none
    std::uint32_t force = 0;  ///< maximum size of a forced value, in bytes; 0: the reader cannot be forced
  };
  static constexpr Layout layout(const Options& options) noexcept {
    return {options.depth, (options.payload + 63) / 64 * 64, options.safe, options.force};
  }
  /// True if `memory`, which another process may have written, is a complete link of this version.
  static bool is_link(const std::byte* memory, std::size_t size) noexcept {
    if (size < sizeof(Block)) return false;
    const auto* block = reinterpret_cast<const Block*>(memory);
    return block->magic == Block::kMagic && block->depth >= 1 && block->depth <= kMaxLinkDepth &&
           block->stride % 64 == 0 &&
           size >= Layout{block->depth, block->stride, block->safe_room, block->force_room}.size();
  }
  /// Turns unused memory into an empty link. The memory's former content is lost.
  static void format(std::byte* memory, const Options& options) noexcept {
    TAKT_CHECK(options.depth >= 1 && options.depth <= kMaxLinkDepth);
    auto* block = reinterpret_cast<Block*>(memory);
    const Layout place = layout(options);
    constexpr auto relaxed = std::memory_order_relaxed;
    block->depth = options.depth;
    block->stride = (options.payload + 63) / 64 * 64;
    block->is_queue = options.is_queue ? 1 : 0;
    block->wake_bits = options.wake_bits;
    block->deadline_ns = options.deadline_ns;
    block->safe_room = options.safe;
    block->safe_size.store(0, relaxed);
    block->force_room = options.force;
    block->force_until_ns.store(0, relaxed);
    for (auto* word : {&block->forced, &block->force_size, &block->force_held}) word->store(0, relaxed);
    block->trusted_from.store(options.safe == 0 ? 0 : kNobody, relaxed);
    block->sender_clock_ns.store(0, relaxed);
    block->newest_ns.store(0, relaxed);
    for (auto* counter : {&block->written, &block->overwritten, &block->unfit, &block->taken, &block->refused,
                          &block->late}) {
      counter->store(0, relaxed);
    }
    auto* slots = reinterpret_cast<Atomic<std::uint64_t>*>(memory + place.slots());
    auto* heads = reinterpret_cast<Head*>(memory + place.heads());
    for (std::uint32_t i = 0; i < options.depth; ++i) slots[i].store(SlotWord::make(false, 0, i), relaxed);
    for (std::uint32_t i = 0; i < place.buffers(); ++i) {
      heads[i].sequence.store(0, relaxed);
      heads[i].valid_ns.store(0, relaxed);
    }
    block->writer_has.store(options.depth, relaxed);
    block->writer_takes.store(SlotWord::make(false, 0, options.depth), relaxed);
    block->reader_has.store(SlotWord::make(false, 0, options.depth + 1), relaxed);
    block->reader_takes.store(SlotWord::make(false, 0, options.depth + 1), relaxed);
    block->magic = Block::kMagic;
    block->enabled.store(options.enabled ? 1 : 0, std::memory_order_seq_cst);
  }

  [[nodiscard]] explicit operator bool() const noexcept { return block_ != nullptr; }
  [[nodiscard]] Block& block() const noexcept { return *block_; }
  [[nodiscard]] std::uint32_t depth() const noexcept { return layout_.depth(); }
  [[nodiscard]] std::uint32_t stride() const noexcept { return layout_.stride(); }
  [[nodiscard]] std::uint32_t buffers() const noexcept { return layout_.buffers(); }
  [[nodiscard]] bool has_buffer(std::uint32_t buffer) const noexcept { return buffer < layout_.buffers(); }
  [[nodiscard]] std::size_t size() const noexcept { return layout_.size(); }
  /// Returns the index of the slot that holds the sample with this number.
  [[nodiscard]] std::uint32_t place_of(std::uint64_t sequence) const noexcept {
    return static_cast<std::uint32_t>((sequence - 1) % layout_.depth());
  }
  [[nodiscard]] std::uint32_t after(std::uint32_t place) const noexcept {
    return place + 1 == layout_.depth() ? 0 : place + 1;
  }
  [[nodiscard]] Atomic<std::uint64_t>& slot(std::uint32_t place) const noexcept { return slots_[place]; }
  [[nodiscard]] Head& head(std::uint32_t buffer) const noexcept { return heads_[buffer]; }
  [[nodiscard]] std::byte* payload(std::uint32_t buffer) const noexcept {
    return payloads_ + std::size_t{buffer} * layout_.stride();
  }

  /// True if the link has room for a safe value. The reader gets the safe value instead of samples that are
  /// not trusted.
  [[nodiscard]] bool has_safe_place() const noexcept { return layout_.safe_room() != 0; }
  /// The safe value as CDR; empty while the value is not known.
  [[nodiscard]] std::span<const std::byte> safe() const noexcept {
    const std::uint32_t size = block_->safe_size.load(std::memory_order_acquire);
    return {safe_, std::min(size, layout_.safe_room())};
  }
  /// Sets the safe value, as CDR. The node calls this once. Ignores a value that is too large, because such a
  /// value is not valid for the type.
  void give_safe(std::span<const std::byte> value) const noexcept {
    if (value.size() > layout_.safe_room()) return;
    std::copy(value.begin(), value.end(), safe_);
    block_->safe_size.store(static_cast<std::uint32_t>(value.size()),
                            std::memory_order_release);  // after the bytes; pairs with the load in safe()
  }
  /// Makes all samples untrusted from now on, because the writer does not execute. The node calls it, even
  /// while the writer is writing.
  void withhold() const noexcept { block_->trusted_from.store(kNobody, std::memory_order_release); }
  /// Makes all samples that are written from now on trusted, because the writer executes or is about to
  /// execute. The node calls it.
  void trust() const noexcept {
    // Only the node stores `trusted_from`. A sample that the writer publishes at this moment may count as
    // trusted or not: its number is not compared with anything else.
    if (block_->trusted_from.load(std::memory_order_relaxed) != kNobody) return;
    const std::uint64_t written = block_->written.load(std::memory_order_relaxed);
    block_->trusted_from.store(written + 1, std::memory_order_release);
  }
  [[nodiscard]] bool is_withheld() const noexcept { return trusted_from() == kNobody; }
  [[nodiscard]] std::uint64_t trusted_from() const noexcept {
    return block_->trusted_from.load(std::memory_order_acquire);
  }

  /// True if the link has room for a forced value.
  [[nodiscard]] bool has_force_place() const noexcept { return layout_.force_room() != 0; }
  /// The number of the present force; 0 if the reader is not forced. A real-time thread may call it.
  [[nodiscard]] std::uint32_t forced() const noexcept {
    return block_->forced.load(std::memory_order_acquire);
  }
  /// True if the reader gets the forced value at this time (monotonic). A real-time thread may call it.
  [[nodiscard]] bool is_forced(std::int64_t now_ns) const noexcept {
    return forced() != 0 && now_ns < block_->force_until_ns.load(std::memory_order_relaxed);
  }
  /// Makes the reader use this value, as CDR, from its next read() until `until_ns` (monotonic). `number`
  /// differs from 0 and from the numbers of all former forces of the link. Returns false if the value is too
  /// large, or if the reader is just decoding the value of the former force: try again. The node calls it
  /// while the reader is not forced.
  [[nodiscard]] bool force(std::uint32_t number, std::span<const std::byte> value,
                           std::int64_t until_ns) const noexcept {
    // SYNC: forced value. force() runs after end_force() has stored 0 in `forced`, and then reads
    // `force_held`; read_force() stores `force_held`, and then reads `forced`. All threads observe these
    // accesses in one order. So either this function sees that the reader holds the former value, or the
    // reader sees that the former force has ended, and does not touch the bytes.
    if (value.size() > layout_.force_room() || block_->force_held.load(std::memory_order_seq_cst) != 0)
      return false;
    std::copy(value.begin(), value.end(), force_);
    block_->force_size.store(static_cast<std::uint32_t>(value.size()), std::memory_order_relaxed);
    block_->force_until_ns.store(until_ns, std::memory_order_relaxed);
    // After the bytes, their size and the time: whoever reads this number reads those, too.
    block_->forced.store(number, std::memory_order_seq_cst);
    return true;
  }
  /// Lets the force last until `until_ns` (monotonic). The node calls it.
  void renew_force(std::int64_t until_ns) const noexcept {
    block_->force_until_ns.store(until_ns, std::memory_order_relaxed);
  }
  /// Ends the force: from its next read() on, the reader uses the samples again. The node calls it.
  void end_force() const noexcept { block_->forced.store(0, std::memory_order_seq_cst); }
  /// Passes the bytes of force `number` to `decode`, and returns its result. Returns false without a call if
  /// this force has ended. Only the reader calls it; a real-time thread may.
  template <class Decode>
  bool read_force(std::uint32_t number, const Decode& decode) const noexcept {
    block_->force_held.store(number, std::memory_order_seq_cst);  // SYNC: forced value, see force()
    const bool decoded =
        block_->forced.load(std::memory_order_seq_cst) == number &&
        decode(static_cast<const std::byte*>(force_),
               std::min(block_->force_size.load(std::memory_order_relaxed), layout_.force_room()));
    block_->force_held.store(0, std::memory_order_release);
    return decoded;
  }

 private:
  Block* block_ = nullptr;
  Layout layout_{1, 0};
  Atomic<std::uint64_t>* slots_ = nullptr;
  Head* heads_ = nullptr;
  std::byte* payloads_ = nullptr;
  std::byte* safe_ = nullptr;
  std::byte* force_ = nullptr;
};

/// The state of a link's writer or reader side while no LinkWriter or LinkReader uses that side: the side's
/// buffer, and the last sample that the side published or finished. The opposite side may be in use or
/// unused.
struct LinkPlace {
  std::uint32_t buffer = 0;
  std::uint64_t sequence = 0;
};

// find_writer() and find_reader() run when the process of the side has ended or the side is not active, so
// all its stores are visible. They are release stores, so also a processor that reorders stores has made them
// in the order of the code: up to the point at which the process was killed, and none after it.
template <template <class> class Atomic>
LinkPlace find_writer(const BasicLink<Atomic>& link) noexcept {
  constexpr auto acquire = std::memory_order_acquire;
  const std::uint64_t takes = link.block().writer_takes.load(acquire);
  const std::uint64_t sequence = SlotWord::sequence(takes);
  // Only a writer changes the number in a slot, so the number shows whether the announced sample was
  // published.
  const bool published =
      sequence == 0 || SlotWord::sequence(link.slot(link.place_of(sequence)).load(acquire)) >= sequence;
  const LinkPlace found = published ? LinkPlace{SlotWord::index(takes), sequence}
                                    : LinkPlace{link.block().writer_has.load(acquire), sequence - 1};
  return link.has_buffer(found.buffer) ? found : LinkPlace{};
}

template <template <class> class Atomic>
LinkPlace find_reader(const BasicLink<Atomic>& link) noexcept {
  constexpr auto acquire = std::memory_order_acquire;
  const std::uint64_t has = link.block().reader_has.load(acquire);
  const std::uint64_t takes = link.block().reader_takes.load(acquire);
  const std::uint32_t old = SlotWord::index(has);
  const std::uint32_t wanted = SlotWord::index(takes);
  const std::uint64_t sequence = SlotWord::sequence(takes);
  const LinkPlace not_taken{old, SlotWord::sequence(has)};
  const LinkPlace taken{wanted, sequence};
  if (!link.has_buffer(old) || !link.has_buffer(wanted)) return {};  // a process wrote out of bounds
  if (old == wanted) return not_taken;                               // the reader had finished its exchange
  // If the memory is intact, the second attempt always succeeds: if the writer was active during the first
  // attempt, it has filled its buffer by the second. The limit of 100 attempts guards against damaged memory.
  for (int attempt = 0; attempt < 100; ++attempt) {
    const std::uint64_t word = link.slot(link.place_of(sequence)).load(acquire);
    // If the slot still has this number, one of the buffers `old` and `wanted` is in the slot, and the other
    // is the reader's.
    if (SlotWord::sequence(word) == sequence) return SlotWord::index(word) == old ? taken : not_taken;
    // Otherwise the writer has overtaken the reader and has taken the buffer from the slot. If it has filled
    // that buffer again, the buffer contains a newer sample.
    if (link.head(old).sequence.load(acquire) > sequence) return taken;
    if (link.head(wanted).sequence.load(acquire) > sequence) return not_taken;
    // If the writer has not filled that buffer again, the buffer is still the writer's own.
    const std::uint32_t writers = SlotWord::index(link.block().writer_takes.load(acquire));
    if (writers == old) return taken;
    if (writers == wanted) return not_taken;
  }
  return not_taken;
}

/// Empties a link whose payloads were in a process that has ended. Neither the writer nor the reader may be
/// active. Sample numbers and counts continue.
template <template <class> class Atomic>
void drop_samples(const BasicLink<Atomic>& link) noexcept {
  constexpr auto order = std::memory_order_seq_cst;
  const std::uint64_t newest = find_writer(link).sequence;
  const std::uint64_t has = SlotWord::make(false, newest, find_reader(link).buffer);
  for (std::uint32_t i = 0; i < link.depth(); ++i) {
    link.slot(i).store(link.slot(i).load(order) & ~SlotWord::kFull, order);
  }
  link.block().reader_has.store(has, order);
  link.block().reader_takes.store(has, order);
  link.block().newest_ns.store(0, order);
}

/// States when a writer or reader object takes over its side of a link: `now`, in its constructor, or
/// `later`, in attach(), because another object still uses that side.
enum class Attach { now, later };

/// Writes samples into a link. A link has only one writer, and only one thread at a time may use it. A
/// real-time thread may call every function.
template <template <class> class Atomic>
class BasicLinkWriter {
 public:
  BasicLinkWriter() = default;
  explicit BasicLinkWriter(BasicLink<Atomic> link, Attach when = Attach::now) noexcept : link_(link) {
    if (when == Attach::now) attach();
  }
  /// Takes over the writer's side of the link and continues after the last sample of the former writer. The
  /// former writer must not be active.
  void attach() noexcept {
    const LinkPlace found = find_writer(link_);
    private_ = found.buffer;
    sequence_ = found.sequence + 1;
    place_ = link_.place_of(sequence_);
    link_.block().writer_has.store(private_, std::memory_order_seq_cst);
    link_.block().writer_takes.store(SlotWord::make(false, found.sequence, private_),
                                     std::memory_order_seq_cst);
    link_.block().written.store(found.sequence, std::memory_order_relaxed);
  }

  [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(link_); }
  [[nodiscard]] const BasicLink<Atomic>& link() const noexcept { return link_; }
  /// The number of the buffer to fill next. No other thread accesses this buffer.
  [[nodiscard]] std::uint32_t buffer() const noexcept { return private_; }
  /// The number of the next sample.
  [[nodiscard]] std::uint64_t next() const noexcept { return sequence_; }

  /// Passes the buffer with its sample to the reader, which may take the sample from `valid_ns` on
  /// (monotonic; 0: at once). `size`: bytes of the payload. If the link is full, the sample overwrites the
  /// oldest one. Wait-free.
  void publish(std::uint32_t size, std::int64_t stamp_ns, std::int64_t valid_ns = 0) noexcept {
    auto& block = link_.block();
    constexpr auto relaxed = std::memory_order_relaxed;
    auto& head = link_.head(private_);
    head.stamp_ns = stamp_ns;
    head.size = size;
    head.sequence.store(sequence_, relaxed);
    // A reader that sees this value in take() also sees that the sample that was in this buffer has left its
    // slot.
    head.valid_ns.store(valid_ns, std::memory_order_release);
    auto& slot = link_.slot(place_);
    const std::uint64_t mine = SlotWord::make(true, sequence_, private_);
    std::uint64_t old = slot.load(std::memory_order_acquire);
    // This loop runs at most twice: the reader may empty a full slot between load and exchange, but the
    // reader never changes an empty slot.
    do {
      if (!link_.has_buffer(SlotWord::index(old))) return;  // a process wrote out of bounds
      block.writer_takes.store(SlotWord::make(false, sequence_, SlotWord::index(old)),
                               std::memory_order_release);
    } while (!slot.compare_exchange_strong(old, mine, std::memory_order_seq_cst, std::memory_order_acquire));
    // From now on, the writer has the buffer of `old`, and the reader may take the sample. The exchange
    // releases the sample to take(), and acquires what the reader has read from the buffer of `old`. It is
    // sequentially consistent, because the writer then loads whether the reader sleeps (WakeBits::note()),
    // and the reader announces its sleep and then calls news_at().
    private_ = SlotWord::index(old);
    block.writer_has.store(private_, std::memory_order_release);
    if (SlotWord::full(old)) block.overwritten.store(block.overwritten.load(relaxed) + 1, relaxed);
    block.newest_ns.store(stamp_ns, relaxed);
    block.written.store(sequence_, relaxed);
    ++sequence_;
    place_ = link_.after(place_);
  }

 private:
  BasicLink<Atomic> link_;
  std::uint32_t private_ = 0;
  std::uint32_t place_ = 0;
  std::uint64_t sequence_ = 1;
};

/// Reads samples from a link. A link has only one reader, and only one thread at a time may use it. A
/// real-time thread may call every function.
template <template <class> class Atomic>
class BasicLinkReader {
 public:
  BasicLinkReader() = default;
  explicit BasicLinkReader(BasicLink<Atomic> link, Attach when = Attach::now) noexcept : link_(link) {
    if (when == Attach::now) attach();
  }
  /// Takes over the reader's side of the link and continues after the last sample that the former reader
  /// took. The former reader must not be active.
  void attach() noexcept {
    const LinkPlace found = find_reader(link_);
    private_ = found.buffer;
    go_to(found.sequence + 1);
    const std::uint64_t has = SlotWord::make(false, found.sequence, private_);
    link_.block().reader_has.store(has, std::memory_order_seq_cst);
    link_.block().reader_takes.store(has, std::memory_order_seq_cst);
    link_.block().force_held.store(0, std::memory_order_release);  // a dead reader holds nothing any more
  }

  [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(link_); }
  [[nodiscard]] const BasicLink<Atomic>& link() const noexcept { return link_; }
  /// The buffer of the sample that was taken last. Its content does not change until the next take().
  [[nodiscard]] std::uint32_t buffer() const noexcept { return private_; }
  /// The info of the sample that was taken last; `sequence` is 0 before the first sample.
  [[nodiscard]] SampleInfo info() const noexcept {
    const auto& head = link_.head(private_);
    return {head.sequence.load(std::memory_order_relaxed), head.stamp_ns, std::min(head.size, link_.stride()),
            head.valid_ns.load(std::memory_order_relaxed)};
  }

  /// The monotonic time in ns from which take() finds a sample: 0 for at once, kNever if there is no sample.
  /// Threads other than the reader's may also call this, but their result may already be out of date.
  [[nodiscard]] std::int64_t news_at() const noexcept {
    // See publish(). The load also acquires the sample's `valid_ns`.
    const std::uint64_t word = link_.slot(place()).load(std::memory_order_seq_cst);
    if (!SlotWord::full(word) || !link_.has_buffer(SlotWord::index(word))) return kNever;
    return link_.head(SlotWord::index(word)).valid_ns.load(std::memory_order_relaxed);
  }
  [[nodiscard]] bool has_news() const noexcept { return news_at() != kNever; }

  /// Takes the next sample: the oldest one that was not overwritten, if it is valid at `now_ns` (monotonic).
  /// Returns false if there is no such sample. Lock-free: take() starts again only if the writer overwrote
  /// the sample that take() was about to take.
  bool take(std::int64_t now_ns = kNever) noexcept {
    auto& block = link_.block();
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      auto& slot = link_.slot(place());
      std::uint64_t word = slot.load(std::memory_order_acquire);
      if (!SlotWord::full(word)) return false;
      if (SlotWord::sequence(word) != next_) {  // the writer has overtaken the reader, so continue with the
                                                // oldest sample
        go_to(SlotWord::sequence(word) - link_.depth() + 1);
        if (link_.depth() > 1) continue;
      }
      if (!link_.has_buffer(SlotWord::index(word))) return false;
      // If the writer replaces the sample now, the loaded `valid_ns` may belong to the new sample. In this
      // case, the slot's word has changed, and the loop tries again.
      if (link_.head(SlotWord::index(word)).valid_ns.load(std::memory_order_acquire) > now_ns) {
        if (slot.load(std::memory_order_acquire) == word) return false;
        continue;
      }
      const std::uint64_t takes = word & ~SlotWord::kFull;
      block.reader_takes.store(takes, std::memory_order_release);
      if (!slot.compare_exchange_strong(word, SlotWord::make(false, next_, private_),
                                        std::memory_order_seq_cst, std::memory_order_acquire)) {
        continue;
      }
      // From now on, the reader has the sample, and the writer may take the reader's former buffer. The
      // exchange acquires the sample, and releases that buffer after the reader's last access to it.
      private_ = SlotWord::index(word);
      block.reader_has.store(takes, std::memory_order_release);
      block.taken.store(block.taken.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      ++next_;
      place(link_.after(place()));
      return true;
    }
    return false;
  }

 private:
  static constexpr int kAttempts = 64;

  // Reads `place_` atomically, because other threads read it in news_at().
  [[nodiscard]] std::uint32_t place() const noexcept {
    return std::atomic_ref{place_}.load(std::memory_order_relaxed);
  }
  void place(std::uint32_t next) noexcept { std::atomic_ref{place_}.store(next, std::memory_order_relaxed); }

  void go_to(std::uint64_t sequence) noexcept {
    next_ = sequence;
    place(link_.place_of(sequence));
  }

  BasicLink<Atomic> link_;
  std::uint32_t private_ = 0;
  mutable std::uint32_t place_ = 0;  // mutable, because atomic_ref needs an object that is not const
  std::uint64_t next_ = 1;
};

using LinkBlock = BasicLinkBlock<std::atomic>;
using LinkLayout = BasicLinkLayout<std::atomic>;
using Link = BasicLink<std::atomic>;
using LinkWriter = BasicLinkWriter<std::atomic>;
using LinkReader = BasicLinkReader<std::atomic>;

}  // namespace takt::channel
