#include <takt/node/node.hpp>

#include <array>
#include <atomic>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <takt/agent/agent.hpp>
#include <takt/dds/commands.hpp>
#include <takt/dds/topics.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/host/component_path.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/validate.hpp>
#include <takt/node/device_platform.hpp>
#include <takt/node/fault_record.hpp>
#include <takt/node/inspection.hpp>
#include <takt/node/kept_deployment.hpp>
#include <takt/node/log.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/notice.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/signals.hpp>
#include <takt/os/trial.hpp>
#include <takt/os/writers.hpp>
#include <takt/security/identity.hpp>
#include <takt/security/signature.hpp>
#include <takt/wire/words.hpp>
#include "dds_publisher.hpp"

namespace takt::node {

using agent::Agent;
using supervision::Supervisor;

namespace {

/// The interval at which the main loop reads what the executors publish.
constexpr int kPollEveryMs = 5;
/// The interval at which the fault record is written to disk. A power failure loses only the events of this
/// interval.
constexpr Nanoseconds kSyncEvery = std::chrono::seconds{1};
/// The interval between warnings about an identity that expires soon.
constexpr Nanoseconds kWarnEvery = std::chrono::hours{24};
/// The number of wake-ups that the node measures when it starts. They show how late this machine usually
/// wakes a thread.
constexpr std::size_t kWakeUpsTried = 20;
constexpr std::chrono::microseconds kWakeUpPause{500};

/// A queue of functions for the main loop. Other threads add functions, and the main loop calls them.
class Inbox {
 public:
  explicit Inbox(os::Notice notice) : notice_(std::move(notice)) {}

  /// The next step handles the news, at most kPollEveryMs later.
  void put(std::function<void(Agent&)> news) {
    const std::lock_guard lock{mutex_};
    news_.push_back(std::move(news));
  }
  /// A step handles the news at once.
  void put_at_once(std::function<void(Agent&)> news) {
    put(std::move(news));
    notice_.give();
  }
  void serve(Agent& agent) {
    notice_.take();
    std::deque<std::function<void(Agent&)>> news;
    {
      const std::lock_guard lock{mutex_};
      news.swap(news_);
    }
    for (const auto& each : news) each(agent);
  }
  [[nodiscard]] const os::Fd& fd() const noexcept { return notice_.fd(); }

 private:
  os::Notice notice_;
  std::mutex mutex_;
  std::deque<std::function<void(Agent&)>> news_;
};

// Returns an id for this node. No other node has this id, not even an earlier node with the same process id.
std::string new_node_id() {
  std::random_device random;
  std::array<char, 9> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x", random());
  return wire::cut(os::host_name(), 40) + "-" + std::to_string(os::process_id()) + "-" + digits.data();
}

int refuse(const Problems& problems) {
  std::fprintf(stderr, "%s\n", to_text(problems).c_str());
  return 1;
}

bool has_expired(const security::Identity& identity) {
  return identity.until <= os::wall_ns() / 1'000'000'000;
}

/// Logs that the identity expires soon. Returns the text if it has expired, otherwise an empty text.
std::string warn_of_expiry(const security::Identity& identity, const NodeOptions& options) {
  const std::string warning = security::expiry_warning(identity.until, os::wall_ns() / 1'000'000'000);
  if (warning.empty()) return {};
  const bool expired = has_expired(identity);
  const std::string text =
      "its identity must be renewed: " + warning +
      (expired
           ? "; the other participants of the cell reject this node until it is started again with a new one"
           : "") +
      "; run takt secure renew DIR " + identity.subject.name + ", copy its folder again and restart the node";
  log(options.device, "", "warning: " + text);
  return expired ? text : std::string{};
}

/// Fails if the identity does not belong to this device, because no other participant would accept it.
Result<void> check_identity(const dds::Participant& participant, const NodeOptions& options) {
  const auto& identity = participant.identity();
  if (!identity) {
    if (!options.quiet)
      log(options.device, "",
          "security is off: anyone on its network can command this device and read its data");
    return {};
  }
  const security::Subject& subject = identity->subject;
  if (subject.role != security::Role::device || subject.name != options.device) {
    return Problem{identity->folder,
                   "this is the identity of " + std::string{to_text(subject.role)} + " " + subject.name +
                       ", not of device " + options.device,
                   "give the folder of this device's identity"};
  }
  log(options.device, "", "security is on: device " + subject.name + " of cell " + subject.cell);
  warn_of_expiry(*identity, options);
  return {};
}

}  // namespace

int run_node(const NodeOptions& options) {
  if (options.quiet) log_nothing();
  os::survive_broken_pipes();  // the node continues even if the program that reads its output has ended
  os::MessageSocket lifetime{os::take_fd_from_environment(kLifetimeFd)};
  const bool temporary = static_cast<bool>(lifetime.fd());
  // Do this before any thread starts, because a new thread inherits the signal mask.
  const auto signals = os::SignalQueue::of_requests_to_end();
  if (!signals) return refuse(signals.problems());
  if (!model::is_valid_name(options.device)) {
    return refuse({{"takt-node", "'" + options.device + "' is not a valid device name", model::kNameRule}});
  }
  os::pass_on_rights();
  LogThread log_thread;  // outlives all that logs
  const bool keeps_files = !options.state_folder.empty() && (!temporary || options.state_folder_given);
  if (keeps_files) {
    // Create the folder before the check, so that no other user can create it after the check. If this fails,
    // the fault record reports it.
    std::error_code error;
    std::filesystem::create_directories(options.state_folder, error);
    if (auto writers = os::check_writers(options.state_folder); !writers) return refuse(writers.problems());
  }
  const bool real_time = os::may_be_real_time().ok();
  const os::WakeUps wake_ups = os::try_wake_ups(kWakeUpsTried, kWakeUpPause);

  auto notice = os::Notice::create();
  if (!notice) return refuse(notice.problems());
  Inbox inbox{std::move(*notice)};

  std::string identity;
  if (!options.security.empty()) {
    std::error_code error;
    identity = std::filesystem::absolute(
                   security::folder_of(options.security, security::Role::device, options.device), error)
                   .string();
    // Bridges use this identity. Programs of the cell that use DDS themselves use it, too.
    os::set_environment("TAKT_SECURITY", identity);
  }
  // The hosts, and the processes that inspect components, read the path of this certificate from the
  // environment.
  std::string signed_by = options.signed_by;
  const std::string granted = identity + "/" + security::kComponents;
  if (signed_by.empty() && !identity.empty() && os::rights_of(granted)) signed_by = granted;
  if (!signed_by.empty()) {
    if (auto usable = security::check_signer(signed_by, os::wall_ns() / 1'000'000'000); !usable)
      return refuse(usable.problems());
    os::set_environment("TAKT_SIGNED_BY", signed_by);
    host::require_of_components(security::signature_check(signed_by));
    if (!options.quiet)
      log(options.device, "", "only components signed with the key of " + signed_by + " are used");
  }
  auto participant = dds::Participant::create(
      {.name = "takt-node " + options.device,
       .domain = options.domain,
       .discovery = options.discovery,
       .interfaces = options.interfaces,
       .security = identity,
       .refused =
           [&options, &inbox](const std::string& text) {
             log(options.device, "", text);
             inbox.put([text](Agent& a) {
               model::Fault fault;
               fault.kind = model::FaultKind::refused_authentication;
               fault.cause = text;
               a.note(std::move(fault), text);
             });
           },
       .told = [&options](const std::string& text) { log(options.device, "", text); },
       .unreached = [&options](const std::string& text) { log(options.device, "", text); }});
  if (!participant) return refuse(participant.problems());
  const bool secured = (*participant)->identity().has_value();
  if (auto fits = check_identity(**participant, options); !fits) return refuse(fits.problems());
  auto dds_publisher = DdsPublisher::create(*participant);
  if (!dds_publisher) return refuse(dds_publisher.problems());

  Agent::Options agent_options{
      .device = options.device,
      .node = new_node_id(),
      .domain = options.domain,
      .cell = secured ? (*participant)->identity()->subject.cell : "",
      .require_real_time = options.require_real_time,
      .real_time = real_time,
      .temporary = temporary,
      .host_name = os::host_name(),
      .process_id = os::process_id(),
      .store = {},
      .boot = os::boot_id(),
      .record = {},
      .log = [&options](const std::string& text) { log(options.device, "", text); },
      .now = os::now,
      .wall_ns = os::wall_ns,
      .instant_of_wall = os::instant_of_wall,
      .rejection_of = [&participant = **participant](
                          const std::string& device) { return participant.rejection_of(device); }};
  if (!options.state_folder.empty() && !temporary) {
    auto store = DeploymentWriter::create({options.state_folder, options.device, options.domain});
    if (!store) return refuse(store.problems());
    agent_options.store = std::move(*store);
  }
  std::shared_ptr<FaultRecord> record;
  if (keeps_files) {
    record = std::make_shared<FaultRecord>(
        FaultRecord::open(FaultRecord::path(options.state_folder, options.device, options.domain)));
    for (const Problem& problem : record->problems())
      log(options.device, "", "warning: the fault record: " + in_words({problem}));
  }
  agent_options.record = record ? record : std::make_shared<FaultRecord>();
  const std::string traces =
      options.state_folder.empty() || temporary
          ? ""
          : options.state_folder + "/traces/" + options.device + "." + std::to_string(options.domain);
  // The platforms of all Supervisors that still exist.
  std::vector<std::weak_ptr<const DevicePlatform>> platforms;
  // The cell of the command that the agent is receiving. Reading a large descriptor takes a second, and the
  // main loop must not wait for this.
  std::shared_ptr<Result<model::Cell>> received;
  Agent agent{agent_options,
              {.parse =
                   [&received](const std::string& text, const std::string& file) {
                     const auto ready = std::exchange(received, nullptr);
                     return ready ? std::move(*ready) : descriptor::parse(text, file);
                   },
               .inspect = inspect,
               .supervise =
                   [&](Supervisor::Options o) {
                     auto platform = std::make_shared<DevicePlatform>(
                         DevicePlatform::Options{.require_real_time = o.require_real_time,
                                                 .check_real_time = options.check_real_time,
                                                 .wake_ups = wake_ups,
                                                 .state_folder = options.state_folder,
                                                 .traces = traces,
                                                 .participant = *participant});
                     platforms.push_back(platform);
                     return std::make_unique<Supervisor>(std::move(o), std::move(platform));
                   }},
              **dds_publisher};

  // The node reads the state of other nodes before it accepts commands.
  auto devices = dds::Reader<DeviceStatus>::create(
      *participant,
      {.sample =
           [&inbox, &publisher = **dds_publisher, own = agent_options.node](const DeviceStatus& status,
                                                                            wire::WriterId writer) {
             const Instant arrived = os::now();
             if (status.node() != own) publisher.heard(status, arrived);
             inbox.put([status, writer, arrived](Agent& a) { a.receive(status, writer, arrived); });
           },
       .disposed =
           [&inbox](const DeviceStatus& key, wire::WriterId writer) {
             inbox.put([key, writer](Agent& a) { a.others().remove(key, writer); });
           },
       .lost =
           [&inbox](wire::WriterId writer) { inbox.put([writer](Agent& a) { a.others().lost(writer); }); }});
  if (!devices) return refuse(devices.problems());
  auto modules = dds::Reader<LifecycleStatus>::create(
      *participant,
      {.sample =
           [&inbox, &options](const LifecycleStatus& status, wire::WriterId) {
             if (status.device() == options.device) return;
             inbox.put([status](Agent& a) { a.others().receive(status); });
           },
       .disposed = [&inbox](const LifecycleStatus& key,
                            wire::WriterId) { inbox.put([key](Agent& a) { a.others().remove(key); }); },
       .lost = {}});
  if (!modules) return refuse(modules.problems());
  auto server = dds::CommandServer::create(*participant, options.device, agent_options.node,
                                           [&inbox, &received](const wire::WholeCommand& command) {
                                             std::shared_ptr<Result<model::Cell>> cell;
                                             if (command.head.kind() == COMMAND_PREPARE)
                                               cell = std::make_shared<Result<model::Cell>>(descriptor::parse(
                                                   command.data, command.head.value().to_string()));
                                             inbox.put_at_once([command, cell, &received](Agent& a) {
                                               received = cell;
                                               a.receive(command);
                                               received.reset();
                                             });
                                           });
  if (!server) return refuse(server.problems());
  (*dds_publisher)->set_reply_sender([&server](const wire::WholeReply& reply) { server->reply(reply); });

  log_thread.start();
  if (!temporary)
    log(options.device, "", "waits for a deployment on domain " + std::to_string(options.domain));
  std::uint64_t refused = 0;
  agent.note_start();
  if (options.resume)
    agent.resume();
  else
    agent.report_kept();
  Instant warn_again = os::now() + kWarnEvery;
  bool expired = false;
  Instant sync_at = os::now() + kSyncEvery;
  while (!agent.ended()) {
    if (secured && (os::now() >= warn_again || (!expired && has_expired(*(*participant)->identity())))) {
      warn_again = os::now() + kWarnEvery;
      const std::string text = warn_of_expiry(*(*participant)->identity(), options);
      if (!text.empty() && !std::exchange(expired, true))
        agent.note({.kind = model::FaultKind::refused_authentication, .cause = text}, text);
    }
    (*dds_publisher)->kick();
    std::vector<const os::Fd*> fds;
    std::erase_if(platforms, [](const auto& platform) { return platform.expired(); });
    for (const auto& platform : platforms) {
      const std::vector<const os::Fd*> more = platform.lock()->wait_on();
      fds.insert(fds.end(), more.begin(), more.end());
    }
    fds.push_back(&signals->fd());
    fds.push_back(&inbox.fd());
    if (temporary && !lifetime.closed()) fds.push_back(&lifetime.fd());
    os::wait_readable(fds, kPollEveryMs);

    while (signals->next()) agent.end(false);
    if (temporary && !lifetime.closed()) {
      static_cast<void>(lifetime.receive());
      if (lifetime.closed()) agent.end(true);
    }
    inbox.serve(agent);
    const std::uint64_t now_refused =
        devices->refused() + modules->refused() + server->refused() + (*participant)->refused();
    if (const std::uint64_t before = std::exchange(refused, now_refused); now_refused > before) {
      agent.note({.kind = model::FaultKind::refused_packet,
                  .cause =
                      "dropped a packet that is not an RTPS message, is not encrypted in a secured cell, or "
                      "is not a valid sample of takt/device, takt/lifecycle or takt/command",
                  .count = now_refused - before});
    }
    agent.step();
    if (const Instant now = os::now(); record && now >= sync_at) {
      sync_at = now + kSyncEvery;
      record->begin_sync();
    }
  }
  agent.note_end();
  return agent.has_given_way() ? 1 : 0;  // a service manager restarts the node, which then waits
}

}  // namespace takt::node
