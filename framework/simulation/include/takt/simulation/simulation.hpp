// Simulates a whole cell in one process, on virtual time: every device with its executors, modules, programs,
// links and supervision, and the network between them. The same seed gives the same events in the same order.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
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
#include <takt/simulation/injection.hpp>

namespace takt::simulation {

/// A descriptor, with the plans of its devices and the ports of its modules.
struct Version {
  model::Cell cell;
  std::vector<schedule::DevicePlan> plans;
  model::CellPorts ports{};
};

/// What the simulated operator does to the cell.
enum class Action : std::uint8_t {
  deploy,    ///< as takt deploy
  update,    ///< as takt deploy --update, with Options::update
  undeploy,  ///< as takt undeploy
};
enum class Outcome : std::uint8_t {
  done,
  unchanged,  ///< it failed, and every device runs what it ran before
  unknown,    ///< not every device has confirmed the outcome, or the operator does not wait for it
};

/// What the operator has reported at the end of an action.
struct Report {
  Action action = Action::deploy;
  Outcome outcome = Outcome::done;
  std::string transaction;  ///< id of the deployment or update
  std::string why;          ///< why it failed
};
/// Returns the report in words.
std::string to_text(const Report& report);

struct Options {
  std::uint64_t seed = 1;
  Nanoseconds length = std::chrono::seconds{1};  ///< time from T0 until the cell is stopped
  std::vector<Injection> injections{};           ///< faults and commands from a script
  double faults_per_second = 0;                  ///< additional faults, drawn from the seed
  model::Profile profile{};                      ///< measured run times; a module that is not in the profile
                                                 ///< uses its budget
  int cpus = 0;                  ///< CPUs per device for executors that name no CPU; if 0, each of these
                                 ///< executors has its own CPU
  Listener* listener = nullptr;  ///< receives every event; may be null
  /// Each message between nodes and the operator takes up to this time longer, once the cell is deployed.
  Nanoseconds message_delay{};
  const Version* update = nullptr;  ///< the descriptor of Action::update, with the same devices and another
                                    ///< file name; may be null
  /// Called a few hundred times during the simulation, with the simulated time since T0; may be empty.
  std::function<void(Nanoseconds)> progress{};
};

/// T0 of every simulated cell.
inline constexpr Instant kT0 = from_ns(1'000'000'000);

/// The result of a simulation.
struct Course {
  nlohmann::ordered_json report;            ///< the same report as from `takt run`
  Problems failures;                        ///< modules that were given up, and devices that failed
  std::vector<std::string> violations;      ///< violated invariants; empty unless Takt itself has an error
  std::vector<Report> reports;              ///< of the operator's actions after the first deployment
  std::vector<std::string> without_effect;  ///< the faults that had no effect, each with the reason
  /// The descriptor that each device ran at the end, before it was stopped: 0, or 1 for Options::update.
  /// Empty if it ran none.
  std::vector<std::optional<std::uint32_t>> ran;
};

/// Simulates a cell that model::validate() has accepted, with its plans. If `ports` is empty, all inputs of a
/// sporadic module are events. Fails if there is not enough memory. Not for real-time threads.
Result<Course> simulate(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                        const model::CellPorts& ports, const Options& options);

}  // namespace takt::simulation
