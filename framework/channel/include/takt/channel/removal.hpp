// Removes a module from the tables while the executor continues to execute rows, and detects when the removal
// is complete. From then on, no thread is in the module's run() or condition(), and the program of a process
// module is not in its body (the code that it runs for one release). Neither the node nor the executor waits
// for the other. The executor only announces what it is about to do, and then checks whether the module is
// still in the tables.
#pragma once

#include <cstdint>

#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>

namespace takt::channel {

/// All shared memory that shows whether a module's code is running.
struct ModuleMemory {
  std::uint32_t index = 0;       ///< index of the module on its device
  ModuleBlock* block = nullptr;  ///< never null
  const ExecutorBlock* executor =
      nullptr;  ///< the executor whose tables contain the module; null: a non-real-time module
  ReleaseSlot* slot = nullptr;  ///< the release slot of a process module; null for other modules
};

/// Puts the module into the tables. The node calls this function.
inline void put_in(const ModuleMemory& memory) noexcept {
  // Relaxed: an executor loads `in_tables`, which is stored later, before it loads `entered`.
  memory.block->entered.store(memory.block->entered.load(std::memory_order_relaxed) + 1,
                              std::memory_order_relaxed);
  memory.block->in_tables.store(1, std::memory_order_seq_cst);
  if (memory.slot != nullptr) memory.slot->open.store(1, std::memory_order_seq_cst);
}

/// The removal of one module from the tables. Only the node uses this class.
class Removal {
 public:
  /// Takes the module out of the tables. The executor may already have taken it out, because of an error.
  void begin(const ModuleMemory& memory) noexcept {
    memory.block->in_tables.store(0, std::memory_order_seq_cst);
    if (memory.slot != nullptr) memory.slot->open.store(0, std::memory_order_seq_cst);
    // The executor first announces that it executes a row, and then checks whether the module is in the
    // tables. This function first removes the module, and then checks whether the executor executes a row.
    // Because these steps have one total order, this load sees every row that still found the module in the
    // tables.
    row_ = memory.executor == nullptr ? 0 : memory.executor->row_sequence.load(std::memory_order_seq_cst);
  }

  /// Returns true if the removal is complete. The caller then sees everything that the module's code wrote.
  [[nodiscard]] bool over(const ModuleMemory& memory) const noexcept {
    constexpr auto order = std::memory_order_seq_cst;
    const auto runs_it = [&memory](const Activity& activity) {
      return activity.module.load(order) == memory.index + 1;  // pairs with Activity::announce()
    };
    if (memory.block->in_tables.load(order) != 0) return false;
    if (memory.executor != nullptr) {
      const bool in_row = row_ % 2 != 0 && memory.executor->row_sequence.load(order) == row_;
      if (in_row || runs_it(memory.executor->sporadic)) return false;
    }
    if (runs_it(memory.block->background)) return false;
    return memory.slot == nullptr || !memory.slot->in_body();
  }

 private:
  std::uint64_t row_ = 0;  // value of row_sequence at begin(); odd if the executor was executing a row
};

}  // namespace takt::channel
