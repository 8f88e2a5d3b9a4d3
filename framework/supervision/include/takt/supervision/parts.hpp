// The data that a device's supervisor shares with its hosts, programs and flows: the descriptor, the table,
// and the shared memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/channel/channel.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/channel/shared.hpp>
#include <takt/channel/turn.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/hosts.hpp>
#include <takt/model/ports.hpp>
#include <takt/schedule/placement.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/supervision/wiring.hpp>

namespace takt::supervision {

struct Parts {
  /// Plans the device's table and creates its memory. Requires cell, device, paths and ports.
  Result<void> create();

  [[nodiscard]] const model::Device& of_device() const { return cell.devices[device]; }
  /// The index of the executor that a module names.
  [[nodiscard]] std::size_t executor_of(const model::Module& module) const;
  /// The release slot of a module; null if the module has none.
  [[nodiscard]] channel::ReleaseSlot* slot_of(std::uint32_t module) const { return slots[module].data(); }
  /// The saved state of a module, from the module's slot or, if the module has no slot, from `saved`.
  [[nodiscard]] channel::SavedState& saved_of(std::uint32_t module) const {
    return slots[module] ? slots[module][0].saved : saved[module];
  }

  model::Cell cell;
  std::size_t device = 0;
  std::vector<std::string> paths;         ///< path of each module's component; a swap changes the path
  std::vector<model::ModulePorts> ports;  ///< the ports of each module; empty if they are not known

  std::vector<model::HostShare> shares{};  ///< the result of model::hosts_of() for the device
  schedule::DevicePlan plan{};
  schedule::Placement placement{};  ///< the CPUs that the platform has chosen
  bool real_time = true;            ///< false once the machine has denied real-time scheduling

  channel::Channel channel{};
  channel::Shared<channel::WakeWord> wake_word{};
  std::vector<channel::Shared<channel::Turn>> turns{};         ///< one for each executor
  channel::Shared<channel::SavedState> saved{};                ///< one for each module
  std::vector<channel::Shared<channel::ReleaseSlot>> slots{};  ///< one for each module; empty if the module
                                                               ///< has no releases
  Wiring wiring{};
};

}  // namespace takt::supervision
