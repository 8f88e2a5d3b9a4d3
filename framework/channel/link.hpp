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
// the place of a side that died in the middle of this finds out which buffer that side was left with.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include <takt/core/check.hpp>

namespace takt::channel {

/// Of one sample, beside its payload.
struct SampleInfo {
  std::uint64_t sequence;  ///< of the link, from 1 without gaps at the writer
  std::int64_t stamp_ns;   ///< monotonic time of the value: when the run() that wrote it began
  std::uint32_t size;      ///< bytes of the payload
};

/// Begins the memory of a link; slots, sample infos and payloads follow. Nothing in it is a pointer.
struct alignas(64) LinkBlock {
  static constexpr std::uint64_t kMagic = 0x6b6e'696c'0000'0001;  // "link", layout 1

  // Written before anybody uses it.
  std::uint64_t magic;
  std::uint32_t depth;      ///< 1 to 65536; 1: the latest value
  std::uint32_t stride;     ///< bytes of one payload's place, a multiple of 64; 0: the payloads lie elsewhere
  std::uint32_t is_queue;   ///< what is overwritten before it was read counts as dropped
  std::uint32_t wake_bits;  ///< of the bell, pending when a sample was written; 0: nobody waits for one
  std::int64_t deadline_ns;            ///< a value older than this is stale; 0: never
  std::atomic<std::uint32_t> enabled;  ///< 0: a writer does not write here (nobody listens). Set by the node.

  // Written by the writer.
  alignas(64) std::atomic<std::uint64_t> written;  ///< samples so far
  std::atomic<std::int64_t> newest_ns;             ///< stamp of the last one; 0: none yet
  std::atomic<std::uint64_t> overwritten;          ///< before they were read
  std::atomic<std::uint32_t> writer_has;           ///< its buffer. SYNC: hands over
  std::atomic<std::uint64_t> writer_takes;         ///< a SlotWord: what it takes for which sample

  // Written by the reader.
  alignas(64) std::atomic<std::uint64_t> taken;
  std::atomic<std::uint64_t> late;        ///< times that the newest value was found older than the deadline
  std::atomic<std::uint32_t> reader_has;  // SYNC: hands over
  std::atomic<std::uint32_t> reader_takes;
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

/// Where the parts of a link lie behind its block.
class LinkLayout {
 public:
  constexpr LinkLayout(std::uint32_t depth, std::uint32_t stride) noexcept : depth_(depth), stride_(stride) {}
  [[nodiscard]] constexpr std::uint32_t buffers() const noexcept { return depth_ + 2; }
  [[nodiscard]] constexpr std::size_t slots() const noexcept { return sizeof(LinkBlock); }
  [[nodiscard]] constexpr std::size_t infos() const noexcept {
    return up(slots() + std::size_t{depth_} * sizeof(std::atomic<std::uint64_t>));
  }
  [[nodiscard]] constexpr std::size_t payloads() const noexcept {
    return up(infos() + std::size_t{buffers()} * sizeof(SampleInfo));
  }
  [[nodiscard]] constexpr std::size_t size() const noexcept {
    return payloads() + std::size_t{buffers()} * stride_;
  }

 private:
  static constexpr std::size_t up(std::size_t n) noexcept { return (n + 63) / 64 * 64; }
  std::uint32_t depth_;
  std::uint32_t stride_;
};

/// A link's memory, as both sides use it. Copies refer to the same memory.
class Link {
 public:
  Link() = default;
  /// Memory of LinkLayout::size() bytes that was formatted, aligned to 64.
  explicit Link(std::byte* memory) noexcept
      : block_(reinterpret_cast<LinkBlock*>(memory)), layout_(block_->depth, block_->stride) {
    slots_ = reinterpret_cast<std::atomic<std::uint64_t>*>(memory + layout_.slots());
    infos_ = reinterpret_cast<SampleInfo*>(memory + layout_.infos());
    payloads_ = memory + layout_.payloads();
  }

  struct Options {
    std::uint32_t depth = 1;
    std::uint32_t payload = 0;  ///< most bytes of one sample; 0: the payloads lie elsewhere
    bool is_queue = false;
    std::uint32_t wake_bits = 0;
    std::int64_t deadline_ns = 0;
    bool enabled = true;
  };
  static constexpr LinkLayout layout(const Options& options) noexcept {
    return {options.depth, (options.payload + 63) / 64 * 64};
  }
  /// Makes a link of memory that nobody uses. What was in it is gone.
  static void format(std::byte* memory, const Options& options) noexcept {
    TAKT_CHECK(options.depth >= 1 && options.depth <= kMaxLinkDepth);
    auto* block = reinterpret_cast<LinkBlock*>(memory);
    const LinkLayout place = layout(options);
    constexpr auto relaxed = std::memory_order_relaxed;
    block->depth = options.depth;
    block->stride = (options.payload + 63) / 64 * 64;
    block->is_queue = options.is_queue ? 1 : 0;
    block->wake_bits = options.wake_bits;
    block->deadline_ns = options.deadline_ns;
    block->enabled.store(options.enabled ? 1 : 0, relaxed);
    block->written.store(0, relaxed);
    block->newest_ns.store(0, relaxed);
    block->overwritten.store(0, relaxed);
    block->taken.store(0, relaxed);
    block->late.store(0, relaxed);
    auto* slots = reinterpret_cast<std::atomic<std::uint64_t>*>(memory + place.slots());
    for (std::uint32_t i = 0; i < options.depth; ++i) slots[i].store(SlotWord::make(false, 0, i), relaxed);
    block->writer_has.store(options.depth, relaxed);
    block->writer_takes.store(SlotWord::make(false, 0, options.depth), relaxed);
    block->reader_has.store(options.depth + 1, relaxed);
    block->reader_takes.store(options.depth + 1, relaxed);
    block->magic = LinkBlock::kMagic;
    std::atomic_thread_fence(std::memory_order_seq_cst);
  }

  [[nodiscard]] explicit operator bool() const noexcept { return block_ != nullptr; }
  [[nodiscard]] LinkBlock& block() const noexcept { return *block_; }
  [[nodiscard]] std::uint32_t buffers() const noexcept { return layout_.buffers(); }
  [[nodiscard]] std::atomic<std::uint64_t>& slot_of(std::uint64_t sequence) const noexcept {
    return slots_[(sequence - 1) % block_->depth];
  }
  [[nodiscard]] std::atomic<std::uint64_t>& slot(std::uint32_t place) const noexcept { return slots_[place]; }
  [[nodiscard]] SampleInfo& info(std::uint32_t buffer) const noexcept { return infos_[buffer]; }
  [[nodiscard]] std::byte* payload(std::uint32_t buffer) const noexcept {
    return payloads_ + std::size_t{buffer} * block_->stride;
  }

 private:
  LinkBlock* block_ = nullptr;
  LinkLayout layout_{1, 0};
  std::atomic<std::uint64_t>* slots_ = nullptr;
  SampleInfo* infos_ = nullptr;
  std::byte* payloads_ = nullptr;
};

/// How far a link has come and which buffer belongs to a side that nobody serves at present. The other side
/// may be at work meanwhile, or dead as well.
struct LinkPlace {
  std::uint32_t buffer = 0;
  std::uint64_t newest = 0;  ///< sequence of the last sample that was put into a slot
  std::uint64_t oldest = 0;  ///< of the oldest that is still there; newest + 1: none
};
LinkPlace find_place(const Link& link, bool as_writer);

/// The one writer of a link; one thread at a time. Real-time, but for its construction.
class LinkWriter {
 public:
  LinkWriter() = default;
  explicit LinkWriter(Link link) : link_(link) {
    const LinkPlace place = find_place(link, true);
    private_ = place.buffer;
    sequence_ = place.newest + 1;
    link_.block().writer_has.store(private_, std::memory_order_seq_cst);
    link_.block().writer_takes.store(SlotWord::make(false, place.newest, private_),
                                     std::memory_order_seq_cst);
  }

  [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(link_); }
  [[nodiscard]] const Link& link() const noexcept { return link_; }
  /// The number of the buffer that is to be filled next; nobody else sees it.
  [[nodiscard]] std::uint32_t buffer() const noexcept { return private_; }

  /// The buffer's sample is there for the reader. Wait-free. The oldest one is overwritten where nobody took
  /// it.
  void publish(std::uint32_t size, std::int64_t stamp_ns) noexcept {
    LinkBlock& block = link_.block();
    link_.info(private_) = {sequence_, stamp_ns, size};
    std::atomic<std::uint64_t>& slot = link_.slot_of(sequence_);
    const std::uint64_t mine = SlotWord::make(true, sequence_, private_);
    std::uint64_t old = slot.load(std::memory_order_acquire);
    // Twice at most: the reader takes what it finds full, and never touches a slot that is empty.
    do {
      block.writer_takes.store(SlotWord::make(false, sequence_, SlotWord::index(old)),
                               std::memory_order_release);
    } while (!slot.compare_exchange_strong(old, mine, std::memory_order_seq_cst, std::memory_order_acquire));
    // SYNC: hands over. The buffer of `old` is ours; the sample is the reader's.
    private_ = SlotWord::index(old);
    block.writer_has.store(private_, std::memory_order_release);
    constexpr auto relaxed = std::memory_order_relaxed;
    if (SlotWord::full(old)) block.overwritten.store(block.overwritten.load(relaxed) + 1, relaxed);
    block.newest_ns.store(stamp_ns, relaxed);
    block.written.store(sequence_, relaxed);
    ++sequence_;
  }

 private:
  Link link_;
  std::uint32_t private_ = 0;
  std::uint64_t sequence_ = 1;
};

/// The one reader of a link; one thread at a time. Real-time, but for its construction.
class LinkReader {
 public:
  LinkReader() = default;
  /// Goes on at the oldest sample that is still there.
  explicit LinkReader(Link link) : link_(link) {
    const LinkPlace place = find_place(link, false);
    private_ = place.buffer;
    next_ = place.oldest;
    link_.block().reader_has.store(private_, std::memory_order_seq_cst);
    link_.block().reader_takes.store(private_, std::memory_order_seq_cst);
  }

  [[nodiscard]] explicit operator bool() const noexcept { return static_cast<bool>(link_); }
  [[nodiscard]] const Link& link() const noexcept { return link_; }
  /// The buffer of the sample that was taken last; it stays as it is until the next take().
  [[nodiscard]] std::uint32_t buffer() const noexcept { return private_; }
  [[nodiscard]] const SampleInfo& info() const noexcept { return link_.info(private_); }

  /// Whether take() would find a sample.
  [[nodiscard]] bool has_news() const noexcept {
    return SlotWord::full(link_.slot_of(next_).load(std::memory_order_seq_cst));
  }

  /// The next sample becomes ours: the oldest that was not overwritten. False when there is none. Lock-free:
  /// it starts again only where the writer has meanwhile written over what it was about to take.
  bool take() noexcept {
    LinkBlock& block = link_.block();
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      std::atomic<std::uint64_t>& slot = link_.slot_of(next_);
      std::uint64_t word = slot.load(std::memory_order_acquire);
      if (!SlotWord::full(word)) return false;
      if (SlotWord::sequence(word) != next_) {  // the writer has come round: what is left begins after it
        next_ = SlotWord::sequence(word) - block.depth + 1;
        if (block.depth > 1) continue;
      }
      block.reader_takes.store(SlotWord::index(word), std::memory_order_release);
      if (!slot.compare_exchange_strong(word, SlotWord::make(false, next_, private_),
                                        std::memory_order_seq_cst, std::memory_order_acquire)) {
        continue;
      }
      // SYNC: hands over. The sample is ours; our former buffer is the writer's to take.
      private_ = SlotWord::index(word);
      block.reader_has.store(private_, std::memory_order_release);
      block.taken.store(block.taken.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      ++next_;
      return true;
    }
    return false;
  }

 private:
  static constexpr int kAttempts = 64;
  Link link_;
  std::uint32_t private_ = 0;
  std::uint64_t next_ = 1;
};

}  // namespace takt::channel
