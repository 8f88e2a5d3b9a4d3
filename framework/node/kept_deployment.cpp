#include <takt/node/kept_deployment.hpp>

#include <array>
#include <cstdio>

#include <nlohmann/json.hpp>

#include <takt/descriptor/descriptor.hpp>
#include <takt/model/json.hpp>
#include <takt/node/problems_json.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>

namespace takt::node {

namespace {

using json = nlohmann::ordered_json;

constexpr const char* kFormat = "takt deployment 1";
/// A descriptor as JSON: at most six bytes for each of its own, and a little around it.
constexpr std::size_t kMostBytes = 6 * descriptor::kMaxBytes + 65536;

// FNV-1a. It finds what a disk does to a file, not what a person does.
std::string checksum(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(hash));
  return digits.data();
}

}  // namespace

std::string default_state_folder() {
  if (std::string folder = os::environment("TAKT_STATE_DIR"); !folder.empty()) return folder;
  if (os::is_root()) return "/var/lib/takt";
  if (std::string folder = os::environment("XDG_STATE_HOME"); !folder.empty()) return folder + "/takt";
  return os::environment("HOME") + "/.local/state/takt";
}

DeploymentFile::DeploymentFile(const std::string& folder, const std::string& device, int domain)
    : path_(folder + "/" + device + "." + std::to_string(domain) + ".deployment") {}

// A line that says what follows and what it must sum up to, and the deployment.
Result<void> DeploymentFile::keep(const KeptDeployment& deployment) const {
  const std::string body = model::json_text({{"id", deployment.id},
                                             {"file", deployment.file},
                                             {"text", deployment.text},
                                             {"require_real_time", deployment.require_real_time},
                                             {"t0_ns", deployment.t0_ns}});
  return os::replace_file(path_, std::string{kFormat} + " " + checksum(body) + "\n" + body);
}

Result<std::optional<KeptDeployment>> DeploymentFile::kept() const {
  const auto content = os::read_file(path_, kMostBytes);
  if (!content) return content.problems();
  if (!*content) return std::optional<KeptDeployment>{};
  const auto damaged = [this](const std::string& how) {
    return Problem{path_, "the deployment that was kept there is damaged: " + how, "deploy the cell again"};
  };
  const std::size_t line = (*content)->find('\n');
  if (line == std::string::npos || !(*content)->starts_with(std::string{kFormat} + " "))
    return damaged("it does not begin with \"" + std::string{kFormat} + "\"");
  const std::string body = (*content)->substr(line + 1);
  if ((*content)->substr(0, line) != std::string{kFormat} + " " + checksum(body))
    return damaged("its checksum is another");
  const json value = model::parse_json(body);
  try {
    return std::optional{KeptDeployment{.id = value.at("id"),
                                        .file = value.at("file"),
                                        .text = value.at("text"),
                                        .require_real_time = value.at("require_real_time"),
                                        .t0_ns = value.at("t0_ns")}};
  } catch (const json::exception&) {
    return damaged("something is missing in it");
  }
}

Result<void> DeploymentFile::forget() const { return os::remove_file(path_); }

}  // namespace takt::node
