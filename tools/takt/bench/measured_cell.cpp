#include "measured_cell.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>
#include <takt/os/files.hpp>
#include <takt/os/platform.hpp>

namespace takt::bench {

namespace {

using json = nlohmann::ordered_json;

// An upper bound for the number of releases in a run of this length. The bound includes a margin, because a
// run can last longer than requested.
std::size_t releases_in(Nanoseconds length, Nanoseconds period) {
  return static_cast<std::size_t>(length / period) * 11 / 10 + 1000;
}

}  // namespace

std::vector<std::int64_t> values_of(const std::vector<Served>& served) {
  std::vector<std::int64_t> values;
  values.reserve(served.size());
  for (const Served& one : served) values.push_back(one.value);
  return values;
}

Result<Measured> run_measured(const Table1Case& one, const RunSettings& settings, const ScratchFolder& folder,
                              Interruption& interruption) {
  const std::string record = folder.file("jitter");
  const auto file = folder.write(
      "case.xml", descriptor_of(one, {.period = settings.period,
                                      .cpu = settings.cpu,
                                      .priority = settings.priority,
                                      .file = record,
                                      .releases = releases_in(settings.length, settings.period)}));
  if (!file) return file.problems();
  std::vector<std::string> arguments{
      "run",     *file,   "--json",
      "--quiet", "--for", fmt::format("{}", std::chrono::duration<double>(settings.length).count())};
  if (settings.domain) {
    arguments.emplace_back("--domain");
    arguments.push_back(std::to_string(*settings.domain));
  }
  const Nanoseconds stolen = os::stolen_time();
  const auto output = run_beside("takt", arguments, interruption);
  if (!output) return output.problems();

  const json report = model::parse_json(*output);
  const json& device = report["devices"][0];
  Measured measured{.jitter = Recording::read(record),
                    .cycles = device["executors"][0]["cycles"].get<std::uint64_t>(),
                    .missed = device["executors"][0]["missed"].get<std::uint64_t>(),
                    .real_time = device["real_time"].get<bool>(),
                    .stolen = os::stolen_time() - stolen};
  if (auto removed = os::remove_file(record); !removed) return removed.problems();
  return measured;
}

}  // namespace takt::bench
