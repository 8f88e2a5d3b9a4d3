#include <takt/channel/link.hpp>

#include <algorithm>
#include <vector>

namespace takt::channel {

namespace {

/// All words that say where buffers are, as they were at one moment.
struct Picture {
  std::vector<std::uint64_t> slots;
  std::uint32_t writer_has = 0;
  std::uint64_t writer_takes = 0;
  std::uint32_t reader_has = 0;
  std::uint32_t reader_takes = 0;
  bool operator==(const Picture&) const = default;

  [[nodiscard]] bool in_slot(std::uint32_t buffer) const {
    return std::any_of(slots.begin(), slots.end(),
                       [buffer](std::uint64_t w) { return SlotWord::index(w) == buffer; });
  }

  // The sample that the writer announced is in its slot, or later ones are: then it has what it wanted to
  // take.
  [[nodiscard]] std::uint32_t writers() const {
    const std::uint64_t sequence = SlotWord::sequence(writer_takes);
    const bool done = sequence == 0 || SlotWord::sequence(slots[(sequence - 1) % slots.size()]) >= sequence;
    return done ? SlotWord::index(writer_takes) : writer_has;
  }

  // What the reader announced tells no sample from the next. But of the two buffers that it may have, the
  // other one is in a slot, or is the writer's.
  [[nodiscard]] std::uint32_t readers() const {
    if (in_slot(reader_has)) return reader_takes;
    if (in_slot(reader_takes)) return reader_has;
    return reader_has == writers() ? reader_takes : reader_has;
  }
};

Picture look(const Link& link) {
  constexpr auto order = std::memory_order_seq_cst;
  const LinkBlock& block = link.block();
  Picture picture;
  picture.writer_takes = block.writer_takes.load(order);
  picture.writer_has = block.writer_has.load(order);
  picture.reader_takes = block.reader_takes.load(order);
  picture.reader_has = block.reader_has.load(order);
  for (std::uint32_t i = 0; i < block.depth; ++i) picture.slots.push_back(link.slot(i).load(order));
  return picture;
}

}  // namespace

LinkPlace find_place(const Link& link, bool as_writer) {
  // One side at most is at work. Its words change with every sample, so two equal looks saw one moment.
  Picture picture = look(link);
  for (Picture next = look(link); !(next == picture); next = look(link)) picture = std::move(next);

  LinkPlace place{.buffer = as_writer ? picture.writers() : picture.readers(), .newest = 0, .oldest = 0};
  for (const std::uint64_t word : picture.slots)
    place.newest = std::max(place.newest, SlotWord::sequence(word));
  place.oldest = place.newest + 1;
  for (const std::uint64_t word : picture.slots) {
    if (SlotWord::full(word)) place.oldest = std::min(place.oldest, SlotWord::sequence(word));
  }
  return place;
}

}  // namespace takt::channel
