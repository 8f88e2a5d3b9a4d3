#include "reports/profile_report.hpp"

#include <cmath>
#include <string>

namespace takt::tool {

model::Profile profile_of(const nlohmann::ordered_json& status) {
  model::Profile profile{.cell = status["cell"].get<std::string>(), .modules = {}};
  for (const auto& device : status["devices"]) {
    for (const auto& module : device["modules"]) {
      const auto& run = module["run_us"];
      const auto time = [&run](const char* key) {
        return Nanoseconds{std::llround(run[key].get<double>() * 1e3)};
      };
      // `cycles` counts releases, not measured runs. If the module's only run had not ended when the cell
      // stopped, no run was measured.
      const bool measured = time("max") > Nanoseconds{};
      profile.modules[device["name"].get<std::string>() + "." + module["name"].get<std::string>()] = {
          .runs = measured ? module["cycles"].get<std::uint64_t>() : 0,
          .min = time("min"),
          .p50 = time("p50"),
          .p99 = time("p99"),
          .p999 = time("p999"),
          .max = time("max")};
    }
  }
  return profile;
}

}  // namespace takt::tool
