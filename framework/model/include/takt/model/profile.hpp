// The measured run times of a cell's modules, as `takt run --profile` records them.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <takt/core/time.hpp>

namespace takt::model {

/// The run times of one module: of its run() or, for a process module, of its body (the work for one
/// release).
struct RunTimes {
  std::uint64_t runs = 0;  ///< number of measured runs; 0 if none was measured
  Nanoseconds min{};
  Nanoseconds p50{};
  Nanoseconds p99{};
  Nanoseconds p999{};
  Nanoseconds max{};
};

struct Profile {
  std::string cell;
  std::map<std::string, RunTimes> modules;  ///< by "DEVICE.MODULE"
};

}  // namespace takt::model
