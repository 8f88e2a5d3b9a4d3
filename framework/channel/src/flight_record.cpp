#include <takt/channel/flight_record.hpp>

#include <new>

#include <takt/core/check.hpp>

namespace takt::channel {

namespace {

constexpr std::uint64_t kFlightMagic =
    0x666c'6967'6874'0001;  // "flight" in ASCII, then the layout version: 1

struct alignas(64) FlightHeader {
  std::uint64_t magic;
  std::uint64_t rings;
};

constexpr bool is_capacity(std::uint64_t n) { return (n & (n - 1)) == 0; }

template <class T>
T* flight_at(const os::SharedMemory& memory, std::size_t offset) {
  return std::launder(reinterpret_cast<T*>(memory.data() + offset));
}

}  // namespace

FlightSample FlightWriter::unpack(std::int64_t time_ns, std::uint64_t what) noexcept {
  const auto kind = static_cast<std::uint8_t>(what >> 60);
  return {.time_ns = time_ns,
          .kind = kind < kFlightKinds ? static_cast<FlightKind>(kind) : FlightKind::nothing,
          .module = static_cast<std::uint32_t>(what >> 40) & kMostModule,
          .value = what & kMostValue};
}

std::vector<FlightRecord::RingLayout> FlightRecord::layouts_of(const std::vector<std::uint64_t>& capacities) {
  std::vector<RingLayout> layouts;
  std::size_t at = sizeof(FlightHeader) + (capacities.size() * sizeof(std::uint64_t) + 63) / 64 * 64;
  for (const std::uint64_t capacity : capacities) {
    layouts.push_back({at, capacity});
    at += sizeof(FlightRing) + (capacity * sizeof(FlightEntry) + 63) / 64 * 64;
  }
  layouts.push_back({at, 0});
  return layouts;
}

Result<FlightRecord> FlightRecord::create(const std::vector<std::uint64_t>& capacities) {
  FlightRecord record;
  record.layouts_ = layouts_of(capacities);
  auto memory = os::SharedMemory::create("takt-flight", record.layouts_.back().at);
  if (!memory) return memory.problems();
  record.memory_ = std::move(*memory);
  record.layouts_.pop_back();
  *flight_at<FlightHeader>(record.memory_, 0) = {.magic = kFlightMagic, .rings = capacities.size()};
  for (std::size_t i = 0; i < capacities.size(); ++i) {
    TAKT_CHECK(is_capacity(capacities[i]));
    *flight_at<std::uint64_t>(record.memory_, sizeof(FlightHeader) + i * sizeof(std::uint64_t)) =
        capacities[i];
  }
  return record;
}

Result<FlightRecord> FlightRecord::attach(os::Fd fd) {
  auto memory = os::SharedMemory::attach(std::move(fd));
  if (!memory) return memory.problems();
  FlightRecord record;
  record.memory_ = std::move(*memory);
  const std::size_t size = record.memory_.size();
  const Problems other{fail("another version of Takt created the flight record",
                            "install takt-node and takt-host of the same version")};
  if (size < sizeof(FlightHeader)) return other;
  const FlightHeader header = *flight_at<FlightHeader>(record.memory_, 0);
  if (header.magic != kFlightMagic || header.rings > (size - sizeof(FlightHeader)) / sizeof(std::uint64_t))
    return other;
  std::vector<std::uint64_t> capacities;
  for (std::size_t i = 0; i < header.rings; ++i) {
    capacities.push_back(
        *flight_at<std::uint64_t>(record.memory_, sizeof(FlightHeader) + i * sizeof(std::uint64_t)));
    // Each capacity is at most the size in bytes, so the computation of the total size cannot overflow.
    if (!is_capacity(capacities.back()) || capacities.back() > size) return other;
  }
  record.layouts_ = layouts_of(capacities);
  if (record.layouts_.back().at != size) return other;
  record.layouts_.pop_back();
  return record;
}

FlightRing& FlightRecord::ring(std::size_t index) const noexcept {
  return *flight_at<FlightRing>(memory_, layouts_[index].at);
}

FlightEntry* FlightRecord::entries(std::size_t index) const noexcept {
  return flight_at<FlightEntry>(memory_, layouts_[index].at + sizeof(FlightRing));
}

FlightWriter FlightRecord::writer(std::size_t index) const noexcept {
  if (index >= layouts_.size() || layouts_[index].capacity == 0) return {};
  return {ring(index), entries(index), layouts_[index].capacity};
}

FlightCopy FlightRecord::copy(std::size_t index) const {
  FlightCopy copy;
  const std::uint64_t capacity = layouts_[index].capacity;
  if (capacity == 0) return copy;
  const FlightEntry* const place = entries(index);
  const std::uint64_t end = ring(index).written.load(std::memory_order_acquire);  // pairs with add()
  const std::uint64_t begin = end > capacity ? end - capacity : 0;
  std::vector<FlightSample> all;
  all.reserve(end - begin);
  for (std::uint64_t i = begin; i < end; ++i) {
    const FlightEntry& entry = place[i & (capacity - 1)];
    const std::int64_t time_ns = entry.time_ns.load(std::memory_order_acquire);
    all.push_back(FlightWriter::unpack(time_ns, entry.what.load(std::memory_order_acquire)));
  }
  // The writer may already be overwriting the oldest entry with one that `written` does not count yet.
  const std::uint64_t now = ring(index).written.load(std::memory_order_relaxed);
  const std::uint64_t first = now + 1 > capacity ? now + 1 - capacity : 0;
  const std::uint64_t gone = first <= begin ? 0 : (first < end ? first : end) - begin;
  // If the writer added no entry during the copy, `gone` may still exclude the oldest entry from the copy.
  // That entry does not count as lost.
  copy.lost = now == end ? 0 : gone;
  copy.entries.assign(all.begin() + static_cast<std::ptrdiff_t>(gone), all.end());
  copy.written = end;
  return copy;
}

}  // namespace takt::channel
