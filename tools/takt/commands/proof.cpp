#include "commands/proof.hpp"

#include <numeric>

#include <takt/model/profile_json.hpp>
#include <takt/os/files.hpp>
#include <takt/os/machine.hpp>
#include <takt/schedule/longest_runs.hpp>
#include <takt/schedule/placement.hpp>

namespace takt::tool {

namespace {

/// The maximum size of a profile in bytes, which is enough for more than a million modules.
constexpr std::size_t kLargestProfile = std::size_t{256} << 20U;

}  // namespace

Result<model::Profile> read_profile(const std::string& file) {
  const auto text = os::read_file(file, kLargestProfile);
  if (!text) return Problem{file, in_words(text.problems()), ""};
  if (!*text) return Problem{file, "there is no such file", "create a profile with takt run --profile FILE"};
  return model::parse_profile(**text, file);
}

namespace {

model::Cpus cpus_of(const std::optional<int>& count) {
  if (!count) return os::read_cpus();
  std::vector<int> cpus(static_cast<std::size_t>(*count));
  std::iota(cpus.begin(), cpus.end(), 0);
  return model::Cpus::all(cpus);
}

}  // namespace

Result<Proof> prove(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                    const ProofOptions& options) {
  Proof proof;
  proof.of_profile = !options.profile.empty();
  proof.factor = options.factor;
  model::Profile profile;
  if (proof.of_profile) {
    auto read = read_profile(options.profile);
    if (!read) return read.problems();
    profile = std::move(*read);
  }
  const auto runs = schedule::longest_runs(cell, proof.of_profile ? &profile : nullptr, options.factor);
  if (!runs) return runs.problems();

  const model::Cpus cpus = cpus_of(options.cpus);
  proof.cpus = cpus.permitted.size();
  for (std::size_t i = 0; i < cell.devices.size(); ++i) {
    const model::Device& device = cell.devices[i];
    const schedule::Placement placement = schedule::place(device, cpus);
    for (const std::string& warning : placement.warnings)
      proof.warnings.push_back({"device " + device.name, warning, ""});
    proof.devices.push_back(schedule::worst_cases(device, plans[i], placement, (*runs)[i]));
    const Problems missed = schedule::missed_deadlines(cell, device, proof.devices.back());
    proof.missed.insert(proof.missed.end(), missed.begin(), missed.end());
  }
  return proof;
}

}  // namespace takt::tool
