// How long the modules of a cell took when it ran: what `takt run --profile` wrote down.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <takt/core/time.hpp>

namespace takt::model {

/// Of one module's run(), or of the body of its program.
struct RunTimes {
  std::uint64_t runs = 0;  ///< how many were measured; 0: nothing is known
  Nanoseconds min{};
  Nanoseconds p50{};
  Nanoseconds p99{};
  Nanoseconds p999{};
  Nanoseconds max{};
};

struct Profile {
  std::string cell;
  std::map<std::string, RunTimes> modules;  ///< by "device.module"
};

}  // namespace takt::model
