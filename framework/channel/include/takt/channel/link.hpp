// How a sample gets from one writer to one reader: a connection's memory, between two threads or two
// processes.
//
// A queue that drops its oldest sample when it is full is written by both sides, and whoever holds a lock may
// be killed. So there is none: every sample lies in a buffer, and only the numbers of buffers change hands.
// There are depth + 2 buffers: one in each slot, one private to the writer, one private to the reader. The
// writer fills its own and exchanges it for the one in the next slot; the reader exchanges its own for the
// oldest full one. Whoever has a buffer's number has the buffer alone, so nothing is ever seen half written.
// With depth 1 this is the latest value.
//
// Each side says which buffer it has and which it is about to take for which sample, so that whoever takes
// the place of a side that died in the middle of this finds out which buffer that side was left with, in a
// few steps and whatever the other side does meanwhile.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include <takt/core/check.hpp>

namespace takt::channel {

/// Of one sample, beside its payload.
struct SampleInfo {
  std::uint64_t sequence = 0;  ///< of the link, from 1 without gaps at the writer
  std::int64_t stamp_ns = 0;   ///< monotonic time of the value: when the run() that wrote it began
  std::uint32_t size = 0;      ///< bytes of the payload
  std::int64_t valid_ns = 0;   ///< monotonic time from which on it may be read; 0: at once
};

/// A slot's word: whether a sample is in it, which, and the number of its buffer. An emptied slot keeps the
/// number of the sample that was taken from it, so that the words alone tell how far the link has come.
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
/// Of BasicLinkBlock::trusted_from.
inline constexpr std::uint64_t kNobody = std::numeric_limits<std::uint64_t>::max();
/// A time that does not come.
inline constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

/// Begins the memory of a link; slots, sample infos and payloads follow. Nothing in it is a pointer. `Atomic`
/// is std::atomic but in a test, which wants to be there between any two steps.
template <template <class> class Atomic>
struct alignas(64) BasicLinkBlock {
  static constexpr std::uint64_t kMagic = 0x6b6e'696c'0000'0004;  // "link", layout 4

  // Written before anybody uses it.
  std::uint64_t magic;
  std::uint32_t depth;      ///< 1 to 65536; 1: the latest value
  std::uint32_t stride;     ///< bytes of one payload's place, a multiple of 64; 0: the payloads lie elsewhere
  std::uint32_t is_queue;   ///< what is overwritten before it was read counts as dropped
  std::uint32_t wake_bits;  ///< of the wake_word, pending when a sample was written; 0: nobody waits for one
  std::int64_t deadline_ns;       ///< a value older than this is stale; 0: never
  Atomic<std::uint32_t> enabled;  ///< 0: a writer does not write here (nobody listens). Set by the node.
  std::uint32_t safe_room;        ///< bytes of the place of a safe value; 0: this link has none
  /// Of a link with such a place: samples with a lower number are not given to anybody. kNobody while the
  /// writer does not execute. Set by the node that looks after the reader. SYNC: trusted
  Atomic<std::uint64_t> trusted_from;
  Atomic<std::uint32_t> safe_size;  ///< bytes of the safe value; 0: it is not known yet. SYNC: safe value

  // Written by the writer.
  alignas(64) Atomic<std::uint64_t> written;  ///< samples so far
  Atomic<std::int64_t> newest_ns;             ///< stamp of the last one; 0: none yet
  Atomic<std::uint64_t> overwritten;          ///< before they were read
  Atomic<std::uint64_t> unfit;       ///< values that were not written: a string or sequence beyond its bound
  Atomic<std::uint32_t> writer_has;  ///< its buffer. SYNC: hands over
  Atomic<std::uint64_t> writer_takes;  ///< a SlotWord: what it takes for which sample

  // Written by the reader.
  alignas(64) Atomic<std::uint64_t> taken;
  Atomic<std::uint64_t> refused;  ///< taken, but the bytes were no sample of the type
  Atomic<std::uint64_t> late;     ///< times that the newest value was found older than the deadline
  Atomic<std::uint64_t>
      reader_has;  ///< a SlotWord: its buffer, and the sample it is done with. SYNC: hands over
  Atomic<std::uint64_t> reader_takes;  ///< a SlotWord: which sample it takes in which buffer
};

/// A sample's info in the memory of a link. The number is read by who takes the place of a reader, and the
/// time from which on the sample is valid by a reader that looks whether it may take it, while the writer may
/// be at them.
template <template <class> class Atomic>
struct BasicSampleHead {
  Atomic<std::uint64_t> sequence;
  Atomic<std::int64_t> valid_ns;
  std::int64_t stamp_ns;
  std::uint32_t size;
};

/// Where the parts of a link lie behind its block.
template <template <class> class Atomic>
class BasicLinkLayout {
 public:
  constexpr BasicLinkLayout(std::uint32_t depth, std::uint32_t stride, std::uint32_t safe = 0) noexcept
      : depth_(depth), stride_(stride), safe_(safe) {}
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
  /// Behind the payloads.
  [[nodiscard]] constexpr std::size_t safe() const noexcept {
    return payloads() + std::size_t{buffers()} * stride_;
  }
  [[nodiscard]] constexpr std::uint32_t safe_room() const noexcept { return safe_; }
  [[nodiscard]] constexpr std::size_t size() const noexcept { return up(safe() + safe_); }

 private:
  static constexpr std::size_t up(std::size_t n) noexcept { return (n + 63) / 64 * 64; }
  std::uint32_t depth_;
  std::uint32_t stride_;
  std::uint32_t safe_;
};

/// A link's memory, as both sides use it. Copies refer to the same memory.
template <template <class> class Atomic>
class BasicLink {
 public:
  using Block = BasicLinkBlock<Atomic>;
  using Head = BasicSampleHead<Atomic>;
  using Layout = BasicLinkLayout<Atomic>;

  BasicLink() = default;
  /// Memory of Layout::size() bytes that was formatted, aligned to 64. Depth and stride are read once: what a
  /// program that writes where it should not makes of them later leads nobody out of the memory.
  explicit BasicLink(std::byte* memory) noexcept
      : block_(reinterpret_cast<Block*>(memory)), layout_(block_->depth, block_->stride, block_->safe_room) {
    slots_ = reinterpret_cast<Atomic<std::uint64_t>*>(memory + layout_.slots());
    heads_ = reinterpret_cast<Head*>(memory + layout_.heads());
    payloads_ = memory + layout_.payloads();
    safe_ = memory + layout_.safe();
  }

  struct Options {
    std::uint32_t depth = 1;
    std::uint32_t payload = 0;  ///< most bytes of one sample; 0: the payloads lie elsewhere
    bool is_queue = false;
    std::uint32_t wake_bits = 0;
    std::int64_t deadline_ns = 0;
    bool enabled = true;
    std::uint32_t safe = 0;  ///< most bytes of a safe value; 0: the link has none
  };
  static constexpr Layout layout(const Options& options) noexcept {
    return {options.depth, (options.payload + 63) / 64 * 64, options.safe};
  }
  /// Whether the memory of somebody else is a link of this version, whole.
  static bool is_link(const std::byte* memory, std::size_t size) noexcept {
    if (size < sizeof(Block)) return false;
    const auto* block = reinterpret_cast<const Block*>(memory);
    return block->magic == Block::kMagic && block->depth >= 1 && block->depth <= kMaxLinkDepth &&
           block->stride % 64 == 0 && size >= Layout{block->depth, block->stride, block->safe_room}.size();
  }
  /// Makes a link of memory that nobody uses. What was in it is gone.
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
    block->trusted_from.store(options.safe == 0 ? 0 : kNobody, relaxed);
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
  /// The place of a sample's slot.
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

  /// The link has a place for a safe value: what its reader gets in place of samples that are not to be
  /// trusted.
  [[nodiscard]] bool has_safe_place() const noexcept { return layout_.safe_room() != 0; }
  /// It, as CDR; empty while it is not known. SYNC: safe value
  [[nodiscard]] std::span<const std::byte> safe() const noexcept {
    const std::uint32_t size = block_->safe_size.load(std::memory_order_acquire);
    return {safe_, std::min(size, layout_.safe_room())};
  }
  /// Once, by the node. What does not fit is no value of the type, and is left out.
  void give_safe(std::span<const std::byte> value) const noexcept {
    if (value.size() > layout_.safe_room()) return;
    std::copy(value.begin(), value.end(), safe_);
    block_->safe_size.store(static_cast<std::uint32_t>(value.size()), std::memory_order_release);
  }
  /// The writer does not execute: nothing that it wrote is given to anybody. By the node, while it may be
  /// writing.
  void withhold() const noexcept { block_->trusted_from.store(kNobody, std::memory_order_release); }
  /// It executes, or is about to: what it writes from now on is given to the reader.
  void trust() const noexcept {
    if (block_->trusted_from.load(std::memory_order_relaxed) != kNobody) return;
    const std::uint64_t written = block_->written.load(std::memory_order_relaxed);
    block_->trusted_from.store(written + 1, std::memory_order_release);
  }
  [[nodiscard]] bool is_withheld() const noexcept { return trusted_from() == kNobody; }
  [[nodiscard]] std::uint64_t trusted_from() const noexcept {
    return block_->trusted_from.load(std::memory_order_acquire);
  }

 private:
  Block* block_ = nullptr;
  Layout layout_{1, 0};
  Atomic<std::uint64_t>* slots_ = nullptr;
  Head* heads_ = nullptr;
  std::byte* payloads_ = nullptr;
  std::byte* safe_ = nullptr;
};

/// What belongs to a side that nobody serves at present: its buffer, and the last sample it published, or is
/// done with. The other side may be at work meanwhile, or dead as well.
struct LinkPlace {
  std::uint32_t buffer = 0;
  std::uint64_t sequence = 0;
};

template <template <class> class Atomic>
LinkPlace find_writer(const BasicLink<Atomic>& link) noexcept {
  constexpr auto acquire = std::memory_order_acquire;
  const std::uint64_t takes = link.block().writer_takes.load(acquire);
  const std::uint64_t sequence = SlotWord::sequence(takes);
  // Only a writer changes the number in a slot: it says whether the sample that was announced has come there.
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
  if (!link.has_buffer(old) || !link.has_buffer(wanted)) return {};  // somebody wrote where he should not
  if (old == wanted) return not_taken;                               // it had finished
  // Once again is enough: a writer that has gone on meanwhile has used its buffer. The bound is for nonsense.
  for (int attempt = 0; attempt < 100; ++attempt) {
    const std::uint64_t word = link.slot(link.place_of(sequence)).load(acquire);
    // One of the two is in the slot, and the other is the reader's.
    if (SlotWord::sequence(word) == sequence) return SlotWord::index(word) == old ? taken : not_taken;
    // The writer has come round and took what was in the slot. It has used that one again since ...
    if (link.head(old).sequence.load(acquire) > sequence) return taken;
    if (link.head(wanted).sequence.load(acquire) > sequence) return not_taken;
    // ... or has it still.
    const std::uint32_t writers = SlotWord::index(link.block().writer_takes.load(acquire));
    if (writers == old) return taken;
    if (writers == wanted) return not_taken;
  }
  return not_taken;
}

/// Empties a link whose payloads are gone: those that lie elsewhere, in a process that has ended. Neither
/// side is at work. Numbers and counts go on.
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

/// Whether a side is served at once, or from attach() on, because somebody else serves it until then.
enum class Attach { now, later };

/// The one writer of a link; one thread at a time. Real-time.
template <template <class> class Atomic>
class BasicLinkWriter {
 public:
  BasicLinkWriter() = default;
  explicit BasicLinkWriter(BasicLink<Atomic> link, Attach when = Attach::now) noexcept : link_(link) {
    if (when == Attach::now) attach();
  }
  /// Goes on where whoever served this side before has left it, who is not at work.
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
  /// The number of the buffer that is to be filled next; nobody else sees it.
  [[nodiscard]] std::uint32_t buffer() const noexcept { return private_; }
  /// The number that the next sample gets.
  [[nodiscard]] std::uint64_t next() const noexcept { return sequence_; }

  /// The buffer's sample is there for the reader, from `valid_ns` on. Wait-free. The oldest one is
  /// overwritten where nobody took it.
  void publish(std::uint32_t size, std::int64_t stamp_ns, std::int64_t valid_ns = 0) noexcept {
    auto& block = link_.block();
    constexpr auto relaxed = std::memory_order_relaxed;
    auto& head = link_.head(private_);
    head.stamp_ns = stamp_ns;
    head.size = size;
    head.sequence.store(sequence_, relaxed);
    head.valid_ns.store(valid_ns, relaxed);
    auto& slot = link_.slot(place_);
    const std::uint64_t mine = SlotWord::make(true, sequence_, private_);
    std::uint64_t old = slot.load(std::memory_order_acquire);
    // Twice at most: the reader takes what it finds full, and never touches a slot that is empty.
    do {
      if (!link_.has_buffer(SlotWord::index(old))) return;  // somebody wrote where he should not
      block.writer_takes.store(SlotWord::make(false, sequence_, SlotWord::index(old)),
                               std::memory_order_release);
    } while (!slot.compare_exchange_strong(old, mine, std::memory_order_seq_cst, std::memory_order_acquire));
    // SYNC: hands over. The buffer of `old` is ours; the sample is the reader's.
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

/// The one reader of a link; one thread at a time. Real-time.
template <template <class> class Atomic>
class BasicLinkReader {
 public:
  BasicLinkReader() = default;
  explicit BasicLinkReader(BasicLink<Atomic> link, Attach when = Attach::now) noexcept : link_(link) {
    if (when == Attach::now) attach();
  }
  /// Goes on after the last sample that was taken, by whoever served this side before and is not at work.
  void attach() noexcept {
    const LinkPlace found = find_reader(link_);
    private_ = found.buffer;
    go_to(found.sequence + 1);
    const std::uint64_t has = SlotWord::make(false, found.sequence, private_);
    link_.block().reader_has.store(has, std::memory_order_seq_cst);
    link_.block().reader_takes.store(has, std::memory_order_seq_cst);
  }

  [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(link_); }
  [[nodiscard]] const BasicLink<Atomic>& link() const noexcept { return link_; }
  /// The buffer of the sample that was taken last; it stays as it is until the next take().
  [[nodiscard]] std::uint32_t buffer() const noexcept { return private_; }
  [[nodiscard]] SampleInfo info() const noexcept {
    const auto& head = link_.head(private_);
    return {head.sequence.load(std::memory_order_relaxed), head.stamp_ns, std::min(head.size, link_.stride()),
            head.valid_ns.load(std::memory_order_relaxed)};
  }

  /// From when on take() would find a sample: 0 for at once, kNever when there is none. Also for another
  /// thread, which may then be answered by what was the case a moment ago.
  [[nodiscard]] std::int64_t news_at() const noexcept {
    const std::uint64_t word = link_.slot(place()).load(std::memory_order_seq_cst);
    if (!SlotWord::full(word) || !link_.has_buffer(SlotWord::index(word))) return kNever;
    return link_.head(SlotWord::index(word)).valid_ns.load(std::memory_order_relaxed);
  }
  [[nodiscard]] bool has_news() const noexcept { return news_at() != kNever; }

  /// The next sample becomes ours: the oldest that was not overwritten and is valid at `now_ns`. False when
  /// there is none. Lock-free: it starts again only where the writer has meanwhile written over what it was
  /// about to take.
  bool take(std::int64_t now_ns = kNever) noexcept {
    auto& block = link_.block();
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      auto& slot = link_.slot(place());
      std::uint64_t word = slot.load(std::memory_order_acquire);
      if (!SlotWord::full(word)) return false;
      if (SlotWord::sequence(word) != next_) {  // the writer has come round: what is left begins after it
        go_to(SlotWord::sequence(word) - link_.depth() + 1);
        if (link_.depth() > 1) continue;
      }
      if (!link_.has_buffer(SlotWord::index(word))) return false;
      // The sample's own, if the word is still there when it is exchanged. If not, another lies there.
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
      // SYNC: hands over. The sample is ours; our former buffer is the writer's to take.
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

  // Others look whether there is news.
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
  mutable std::uint32_t place_ = 0;  // mutable: of an atomic_ref
  std::uint64_t next_ = 1;
};

using LinkBlock = BasicLinkBlock<std::atomic>;
using LinkLayout = BasicLinkLayout<std::atomic>;
using Link = BasicLink<std::atomic>;
using LinkWriter = BasicLinkWriter<std::atomic>;
using LinkReader = BasicLinkReader<std::atomic>;

}  // namespace takt::channel
