// Removes a module from the tables while the executor continues to walk rows, and detects when the removal is
// complete. Then no row, sporadic run or body that began before the removal still runs the module's code.
// Neither the node nor the executor waits for the other. The executor only announces what it is about to do,
// and then checks whether the module is still in the tables.
#pragma once

#include <cstdint>

#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>

namespace takt::channel {

/// All shared memory that shows whether a module's code is running.
struct Place {
  std::uint32_t index = 0;       ///< index of the module on its device
  ModuleBlock* block = nullptr;  ///< never null
  const ExecutorBlock* executor =
      nullptr;  ///< the executor whose tables contain the module; null: a non-real-time module
  ReleaseSlot* slot = nullptr;  ///< the release slot of a process module; null for other modules
};

/// Puts the module into the tables. The node calls it.
inline void put_in(const Place& place) noexcept {
  place.block->entered.store(place.block->entered.load(std::memory_order_relaxed) + 1,
                             std::memory_order_relaxed);
  place.block->in_tables.store(1, std::memory_order_seq_cst);                       // SYNC: in tables
  if (place.slot != nullptr) place.slot->open.store(1, std::memory_order_seq_cst);  // SYNC: open
}

/// The removal of one module from the tables. The node uses it.
class Removal {
 public:
  /// Takes the module out of the tables. The executor may have done so already.
  void begin(const Place& place) noexcept {
    place.block->in_tables.store(0, std::memory_order_seq_cst);
    if (place.slot != nullptr) place.slot->open.store(0, std::memory_order_seq_cst);
    // SYNC: in tables, row. The executor first announces that it walks a row, and then checks whether the
    // module is in the tables. This function first removes the module, and then checks whether a row is
    // walked. Because of the total order, this load sees every row that still found the module in the tables.
    row_ = place.executor == nullptr ? 0 : place.executor->row_sequence.load(std::memory_order_seq_cst);
  }

  /// Returns whether the removal is complete. If it is, the caller also sees everything that the module's
  /// code wrote.
  [[nodiscard]] bool over(const Place& place) const noexcept {
    constexpr auto order = std::memory_order_seq_cst;
    const auto runs_it = [&place](const Activity& activity) {
      return activity.module.load(order) == place.index + 1;  // SYNC: activity, announced
    };
    if (place.block->in_tables.load(order) != 0) return false;
    if (place.executor != nullptr) {
      const bool in_row = row_ % 2 != 0 && place.executor->row_sequence.load(order) == row_;
      if (in_row || runs_it(place.executor->sporadic)) return false;
    }
    if (runs_it(place.block->background)) return false;
    return place.slot == nullptr || !place.slot->in_body();
  }

 private:
  std::uint64_t row_ = 0;  // value of row_sequence at begin(); odd: the executor was walking a row
};

}  // namespace takt::channel
