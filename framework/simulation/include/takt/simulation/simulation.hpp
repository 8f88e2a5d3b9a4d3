// A whole cell in one process, on virtual time: every device with its executors, modules, programs, links and
// supervision, and the network between them. One seed, one course.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/profile.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/simulation/event.hpp>
#include <takt/simulation/fault.hpp>

namespace takt::simulation {

struct Options {
  std::uint64_t seed = 1;
  Nanoseconds length = std::chrono::seconds{1};  ///< from T0 to the end
  std::vector<Fault> faults{};                   ///< by a script
  double faults_per_second = 0;                  ///< beside these, drawn from the seed
  model::Profile profile{};                      ///< how long modules run; of others by their budgets
  int cpus = 0;                  ///< of each device, for executors that name none; 0: each has its own
  Listener* listener = nullptr;  ///< hears everything that happens; null: nobody
  /// Told a few hundred times how much of `length` has passed; none: nobody is.
  std::function<void(Nanoseconds)> progress{};
};

/// T0 of every simulated cell.
inline constexpr Instant kT0 = from_ns(1'000'000'000);

struct Course {
  nlohmann::ordered_json report;        ///< as of `takt run`
  Problems failures;                    ///< modules that were given up, devices that ended
  std::vector<std::string> violations;  ///< of what must hold whatever happens; empty: a sound cell
};

/// The cell has passed model::validate(), and the plans are its own. `ports` may be empty: all inputs of a
/// sporadic module are events then. Fails where the machine gives no memory. Not real-time.
Result<Course> simulate(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                        const model::CellPorts& ports, const Options& options);

}  // namespace takt::simulation
