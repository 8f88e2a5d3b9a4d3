// The memory of the flight record of a device, made by its node and kept when a host dies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <takt/channel/flight.hpp>
#include <takt/core/result.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel {

/// What was found in a ring, the oldest first.
struct FlightCopy {
  std::vector<FlightSample> entries;
  std::uint64_t written = 0;  ///< entries since the ring is there
  std::uint64_t lost = 0;     ///< overwritten while they were read
};

/// The rings of one device: two of each executor, of its rows and of its sporadic modules.
class FlightRecord {
 public:
  static constexpr std::size_t of_rows(std::size_t executor) noexcept { return 2 * executor; }
  static constexpr std::size_t of_sporadic(std::size_t executor) noexcept { return 2 * executor + 1; }

  FlightRecord() = default;
  /// The entries that each ring holds: a power of two, or 0 for a ring that nobody writes.
  static Result<FlightRecord> create(const std::vector<std::uint64_t>& capacities);
  /// Fails when the memory was laid out by another version.
  static Result<FlightRecord> attach(os::Fd fd);

  [[nodiscard]] std::size_t rings() const noexcept { return places_.size(); }
  [[nodiscard]] std::uint64_t capacity(std::size_t ring) const noexcept { return places_[ring].capacity; }
  /// Goes on behind what was written before. Of a ring of 0 entries, or with an index past the last, one that
  /// records nothing.
  [[nodiscard]] FlightWriter writer(std::size_t ring) const noexcept;
  /// Any process, while it is written.
  [[nodiscard]] FlightCopy copy(std::size_t ring) const;
  [[nodiscard]] const os::Fd& fd() const noexcept { return memory_.fd(); }

 private:
  struct Place {
    std::size_t at = 0;
    std::uint64_t capacity = 0;
  };
  [[nodiscard]] FlightRing& ring(std::size_t index) const noexcept;
  [[nodiscard]] FlightEntry* entries(std::size_t index) const noexcept;
  /// Where rings of these capacities lie; the last place is the end of them.
  static std::vector<Place> places_of(const std::vector<std::uint64_t>& capacities);

  os::SharedMemory memory_;
  std::vector<Place> places_;
};

}  // namespace takt::channel
