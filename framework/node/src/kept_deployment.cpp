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

using agent::Kept;
using agent::KeptDeployment;

namespace {

using json = nlohmann::ordered_json;

constexpr const char* kDeploymentFormat = "takt deployment 4";
/// The size limit of the file, which contains at most two descriptors. In JSON, each byte becomes at most six
/// bytes; the rest of the file is small.
constexpr std::size_t kMostDeploymentBytes = 2 * 6 * descriptor::kMaxBytes + 131072;
constexpr const char* kUndeployedFormat = "takt undeployed 1";
constexpr std::size_t kMostUndeployedBytes = 65536;

json to_json(const std::optional<KeptDeployment>& kept) {
  if (!kept) return nullptr;
  return {{"id", kept->id},
          {"transaction", kept->transaction},
          {"file", kept->file},
          {"text", kept->text},
          {"require_real_time", kept->require_real_time},
          {"t0_ns", kept->t0_ns},
          {"boot", kept->boot},
          {"t0_monotonic_ns", kept->t0_monotonic_ns},
          {"safe", kept->safe},
          {"devices", kept->devices}};
}

/// Throws json::exception if a value is missing or wrong.
std::optional<KeptDeployment> from_json(const json& value) {
  if (value.is_null()) return std::nullopt;
  const auto time = [&value](const char* name) {
    const json& number = value.at(name);
    const auto positive = model::whole_number(number);
    if (!number.is_number_integer() || (positive && *positive > std::numeric_limits<std::int64_t>::max()))
      throw json::other_error::create(501, name, &value);
    return number.get<std::int64_t>();
  };
  KeptDeployment kept{.id = value.at("id"),
                      .transaction = value.at("transaction"),
                      .file = value.at("file"),
                      .text = value.at("text"),
                      .require_real_time = value.at("require_real_time"),
                      .t0_ns = time("t0_ns"),
                      .boot = value.at("boot"),
                      .t0_monotonic_ns = time("t0_monotonic_ns"),  // negative if it was before the boot
                      .safe = value.at("safe"),
                      .devices = value.at("devices")};
  if (kept.t0_ns < 0) throw json::other_error::create(501, "t0_ns", &value);
  return kept;
}

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

Result<void> DeploymentFile::keep(const Kept& kept) const {
  if (kept.empty()) return os::remove_file(path_);
  return write_whole(
      path_, kDeploymentFormat,
      model::json_text({{"current", to_json(kept.current)}, {"pending", to_json(kept.pending)}}));
}

Result<Kept> DeploymentFile::kept() const {
  const Problem damage{path_, "the saved deployment is damaged", "deploy the cell again"};
  const auto body = read_whole(path_, kDeploymentFormat, kMostDeploymentBytes, damage);
  if (!body) return body.problems();
  if (!*body) return Kept{};
  const json value = model::parse_json(**body);
  try {
    Kept kept{.current = from_json(value.at("current")), .pending = from_json(value.at("pending"))};
    if (!kept.current || kept.current->t0_ns != 0) return kept;
  } catch (const json::exception&) {  // reported below
  }
  return Problem{damage.where, damage.what + ": a value is missing or wrong", damage.fix};
}

Result<void> DeploymentFile::keep_undeployed(const std::vector<std::string>& ids) const {
  return write_whole(undeployed_path_, kUndeployedFormat, model::json_text(ids));
}

void DeploymentFile::save(const Kept& kept, const std::vector<std::string>& undeployed) {
  saved_ = keep(kept);
  if (undeployed_ == undeployed) return;
  const auto written = keep_undeployed(undeployed);
  undeployed_ = written ? std::optional{undeployed} : std::nullopt;
  if (*saved_ && !written) saved_ = written;
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

Result<std::shared_ptr<DeploymentWriter>> DeploymentWriter::create(DeploymentFile file) {
  auto worker = Worker::start("takt-store");
  if (!worker) return worker.problems();
  return std::shared_ptr<DeploymentWriter>{new DeploymentWriter{std::move(file), std::move(*worker)}};
}

DeploymentWriter::DeploymentWriter(DeploymentFile file, std::unique_ptr<Worker> worker)
    : shared_(std::make_shared<Shared>(std::move(file))), worker_(std::move(worker)) {}

void DeploymentWriter::save(const Kept& kept, const std::vector<std::string>& undeployed) {
  {
    const std::lock_guard lock{shared_->mutex};
    shared_->next = Next{kept, undeployed};
    shared_->saved.reset();
  }
  worker_->add([shared = shared_] {
    std::unique_lock lock{shared->mutex};
    const std::optional<Next> next = std::exchange(shared->next, std::nullopt);
    if (!next) return;  // written by an earlier call
    lock.unlock();
    shared->file.save(next->kept, next->undeployed);
    lock.lock();
    if (!shared->next) shared->saved = shared->file.saved();
  });
}

std::optional<Result<void>> DeploymentWriter::saved() const {
  const std::lock_guard lock{shared_->mutex};
  return shared_->saved;
}

}  // namespace takt::node
