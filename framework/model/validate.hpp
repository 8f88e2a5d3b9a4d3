// Everything a cell can be wrong about that needs no file of a component and no machine.
#pragma once

#include <string>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

/// Bounds that hold everywhere, so that memory is decided before anything runs.
inline constexpr std::size_t kMaxNameLength = 63;
inline constexpr std::size_t kMaxDevices = 1000;
inline constexpr std::size_t kMaxModules = 10000;  ///< of one device
inline constexpr std::size_t kMaxExecutors = 64;   ///< of one device

/// A name of a cell, device, executor, module, port or property: a letter or '_', then letters, digits, '_' and '-', at
/// most kMaxNameLength bytes. No dot: `device.module.port` must have one reading.
bool is_valid_name(std::string_view name);

/// All problems of the cell at once, each with `file:line`; empty when there are none.
Problems validate(const Cell& cell);

/// The name of a module that has no <name>: "build/controller1.so" is "controller1".
std::string file_stem(std::string_view filename);

}  // namespace takt::model
