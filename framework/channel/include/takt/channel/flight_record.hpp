// The memory of a device's flight record. The node creates this memory, and keeps it when a host dies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <takt/channel/flight.hpp>
#include <takt/core/result.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel {

/// A copy of a ring, with the oldest entry first.
struct FlightCopy {
  std::vector<FlightSample> entries;
  std::uint64_t written = 0;  ///< number of entries written since the ring was created
  std::uint64_t lost = 0;     ///< number of entries that were overwritten during the copy
};

/// The rings of one device: two for each executor, one for its rows and one for its sporadic modules.
class FlightRecord {
 public:
  static constexpr std::size_t of_rows(std::size_t executor) noexcept { return 2 * executor; }
  static constexpr std::size_t of_sporadic(std::size_t executor) noexcept { return 2 * executor + 1; }

  FlightRecord() = default;
  /// Creates a record with empty rings. `capacities` holds the number of entries of each ring: a power of
  /// two, or 0 if the ring is never written.
  static Result<FlightRecord> create(const std::vector<std::uint64_t>& capacities);
  /// Opens the record that another process created. Fails if another version of Takt created it.
  static Result<FlightRecord> attach(os::Fd fd);

  [[nodiscard]] std::size_t rings() const noexcept { return layouts_.size(); }
  [[nodiscard]] std::uint64_t capacity(std::size_t ring) const noexcept { return layouts_[ring].capacity; }
  /// Returns a writer that appends to the existing entries. The writer records nothing if the ring has
  /// capacity 0 or does not exist.
  [[nodiscard]] FlightWriter writer(std::size_t ring) const noexcept;
  /// Copies a ring, even while its writer continues. Any process may call this. Not for real-time threads,
  /// because copy() allocates memory.
  [[nodiscard]] FlightCopy copy(std::size_t ring) const;
  [[nodiscard]] const os::Fd& fd() const noexcept { return memory_.fd(); }

 private:
  struct RingLayout {
    std::size_t at = 0;
    std::uint64_t capacity = 0;
  };
  [[nodiscard]] FlightRing& ring(std::size_t index) const noexcept;
  [[nodiscard]] FlightEntry* entries(std::size_t index) const noexcept;
  /// Returns where each ring starts in the memory if the rings have these capacities. The last element is the
  /// end of the last ring.
  static std::vector<RingLayout> layouts_of(const std::vector<std::uint64_t>& capacities);

  os::SharedMemory memory_;
  std::vector<RingLayout> layouts_;
};

}  // namespace takt::channel
