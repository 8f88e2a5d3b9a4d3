// Taking a module out of the tables while rows go on, and knowing when it is out: no row, no sporadic run and
// no body that began before is in it any more. Nobody waits for anybody: the real-time side only says what it
// is about to do and looks whether it still may.
#pragma once

#include <cstdint>

#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>

namespace takt::channel {

/// Where a module may be met.
struct Place {
  std::uint32_t index = 0;                  ///< of the module on its device
  ModuleBlock* block = nullptr;             ///< never null
  const ExecutorBlock* executor = nullptr;  ///< whose tables it is in; null: a non-real-time module
  ReleaseSlot* slot = nullptr;              ///< of a program that is released
};

/// By the node.
inline void put_in(const Place& place) noexcept {
  place.block->entered.store(place.block->entered.load(std::memory_order_relaxed) + 1,
                             std::memory_order_relaxed);
  place.block->in_tables.store(1, std::memory_order_seq_cst);                       // SYNC: in tables
  if (place.slot != nullptr) place.slot->open.store(1, std::memory_order_seq_cst);  // SYNC: open
}

/// By the node, one for each module.
class Removal {
 public:
  /// Takes it out. Also where the executor has done so.
  void begin(const Place& place) noexcept {
    place.block->in_tables.store(0, std::memory_order_seq_cst);
    if (place.slot != nullptr) place.slot->open.store(0, std::memory_order_seq_cst);
    // SYNC: in tables, row. A row says that it is walked and then asks whether the module is in the tables;
    // here it is the other way round. In one total order: a row that saw it in the tables is seen here.
    row_ = place.executor == nullptr ? 0 : place.executor->row_sequence.load(std::memory_order_seq_cst);
  }

  /// Whether it is out. What its code wrote is seen by who finds that it is.
  [[nodiscard]] bool over(const Place& place) const noexcept {
    constexpr auto order = std::memory_order_seq_cst;
    const auto meets = [&place](const Activity& activity) {
      return activity.module.load(order) == place.index + 1;  // SYNC: activity, announced
    };
    if (place.block->in_tables.load(order) != 0) return false;
    if (place.executor != nullptr) {
      const bool in_row = row_ % 2 != 0 && place.executor->row_sequence.load(order) == row_;
      if (in_row || meets(place.executor->sporadic)) return false;
    }
    if (meets(place.block->background)) return false;
    return place.slot == nullptr || !place.slot->in_body();
  }

 private:
  std::uint64_t row_ = 0;  // that was being walked, if it is odd
};

}  // namespace takt::channel
