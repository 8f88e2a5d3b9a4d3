#include <takt/node/kept_deployment.hpp>

#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/descriptor/descriptor.hpp>
#include <takt/model/json.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include "whole_file.hpp"

namespace takt::node {

using agent::KeptDeployment;

namespace {

using json = nlohmann::ordered_json;

constexpr const char* kDeploymentFormat = "takt deployment 3";
/// The size limit of the file. In JSON, each byte of the descriptor becomes at most six bytes; the rest of
/// the file is small.
constexpr std::size_t kMostDeploymentBytes = 6 * descriptor::kMaxBytes + 65536;
constexpr const char* kUndeployedFormat = "takt undeployed 1";
constexpr std::size_t kMostUndeployedBytes = 65536;

}  // namespace

std::string default_state_folder() {
  if (std::string folder = os::environment("TAKT_STATE_DIR"); !folder.empty()) return folder;
  if (os::is_root()) return "/var/lib/takt";
  if (std::string folder = os::environment("XDG_STATE_HOME"); !folder.empty()) return folder + "/takt";
  return os::environment("HOME") + "/.local/state/takt";
}

DeploymentFile::DeploymentFile(const std::string& folder, const std::string& device, int domain)
    : path_(folder + "/" + device + "." + std::to_string(domain) + ".deployment"),
      undeployed_path_(folder + "/" + device + "." + std::to_string(domain) + ".undeployed") {}

Result<void> DeploymentFile::keep(const KeptDeployment& deployment) const {
  const std::string body = model::json_text({{"id", deployment.id},
                                             {"file", deployment.file},
                                             {"text", deployment.text},
                                             {"require_real_time", deployment.require_real_time},
                                             {"final", deployment.is_final},
                                             {"t0_ns", deployment.t0_ns},
                                             {"boot", deployment.boot},
                                             {"t0_monotonic_ns", deployment.t0_monotonic_ns},
                                             {"safe", deployment.safe},
                                             {"update", deployment.update}});
  return write_whole(path_, kDeploymentFormat, body);
}

Result<std::optional<KeptDeployment>> DeploymentFile::kept() const {
  const Problem damage{path_, "the saved deployment is damaged", "deploy the cell again"};
  const auto body = read_whole(path_, kDeploymentFormat, kMostDeploymentBytes, damage);
  if (!body) return body.problems();
  if (!*body) return std::optional<KeptDeployment>{};
  const json value = model::parse_json(**body);
  const Problem wrong{damage.where, damage.what + ": a value is missing or wrong", damage.fix};
  try {
    KeptDeployment kept{.id = value.at("id"),
                        .file = value.at("file"),
                        .text = value.at("text"),
                        .require_real_time = value.at("require_real_time"),
                        .is_final = value.at("final"),
                        .boot = value.at("boot"),
                        .safe = value.at("safe"),
                        .update = value.at("update")};
    const auto t0_ns = model::whole_number(value.at("t0_ns"));
    if (!t0_ns || *t0_ns > std::numeric_limits<std::int64_t>::max()) return wrong;
    kept.t0_ns = static_cast<std::int64_t>(*t0_ns);
    const json& monotonic = value.at("t0_monotonic_ns");  // negative if T0 was before the boot
    const auto positive = model::whole_number(monotonic);
    if (!monotonic.is_number_integer() || (positive && *positive > std::numeric_limits<std::int64_t>::max()))
      return wrong;
    kept.t0_monotonic_ns = monotonic;
    return std::optional{std::move(kept)};
  } catch (const json::exception&) {
    return wrong;
  }
}

Result<void> DeploymentFile::forget() const { return os::remove_file(path_); }

Result<void> DeploymentFile::keep_undeployed(const std::vector<std::string>& ids) const {
  return write_whole(undeployed_path_, kUndeployedFormat, model::json_text(ids));
}

Result<std::vector<std::string>> DeploymentFile::undeployed() const {
  const Problem damage{undeployed_path_, "the saved list of undeployed deployments is damaged",
                       "remove the file"};
  const auto body = read_whole(undeployed_path_, kUndeployedFormat, kMostUndeployedBytes, damage);
  if (!body) return body.problems();
  if (!*body) return std::vector<std::string>{};
  try {
    return model::parse_json(**body).get<std::vector<std::string>>();
  } catch (const json::exception&) {
    return damage;
  }
}

}  // namespace takt::node
