#include <takt/node/node.hpp>

#include <array>
#include <atomic>
#include <cstdio>
#include <deque>
#include <functional>
#include <mutex>
#include <random>

#include <takt/dds/commands.hpp>
#include <takt/dds/topics.hpp>
#include <takt/dds/words.hpp>
#include <takt/model/validate.hpp>
#include <takt/node/agent.hpp>
#include <takt/node/log.hpp>
#include <takt/node/voice.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/notice.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/signals.hpp>
#include <takt/os/trial.hpp>

namespace takt::node {

namespace {

/// How often a node looks at what its executors published.
constexpr int kLookEveryMs = 5;
/// Enough to see how late this machine wakes a thread as a rule.
constexpr std::size_t kWakeUpsTried = 20;
constexpr std::chrono::microseconds kWakeUpPause{500};

/// What other threads have for the main loop.
class Inbox {
 public:
  explicit Inbox(os::Notice notice) : notice_(std::move(notice)) {}

  void put(std::function<void(Agent&)> news) {
    {
      const std::lock_guard lock{mutex_};
      news_.push_back(std::move(news));
    }
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

// This node and no other: also not the one that had its process id before.
std::string new_node_id() {
  std::random_device random;
  std::array<char, 9> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x", random());
  return dds::cut(os::host_name(), 40) + "-" + std::to_string(os::process_id()) + "-" + digits.data();
}

int refuse(const Problems& problems) {
  std::fprintf(stderr, "%s\n", to_text(problems).c_str());
  return 1;
}

}  // namespace

int run_node(const NodeOptions& options) {
  if (options.quiet) log_nothing();
  os::survive_broken_pipes();  // whoever reads our log may go; the device stays
  os::MessageSocket lifetime{os::take_fd_from_environment(kLifetimeFd)};
  const bool lent = static_cast<bool>(lifetime.fd());
  const auto signals = os::SignalQueue::of_requests_to_end();  // before there are threads, which inherit it
  if (!signals) return refuse(signals.problems());
  if (!model::is_valid_name(options.device)) {
    return refuse({{"takt-node", "'" + options.device + "' is no name of a device",
                    "a letter or '_', then letters, digits, '_' and '-', at most 63"}});
  }
  const bool real_time = os::may_be_real_time().ok();
  const os::WakeUps wake_ups = os::try_wake_ups(kWakeUpsTried, kWakeUpPause);

  auto notice = os::Notice::create();
  if (!notice) return refuse(notice.problems());
  Inbox inbox{std::move(*notice)};

  auto participant = dds::Participant::create({.name = "takt-node " + options.device,
                                               .domain = options.domain,
                                               .discovery = options.discovery,
                                               .interfaces = options.interfaces});
  if (!participant) return refuse(participant.problems());
  auto voice = Voice::create(*participant);
  if (!voice) return refuse(voice.problems());

  Agent::Options agent_options{.device = options.device,
                               .node = new_node_id(),
                               .domain = options.domain,
                               .require_real_time = options.require_real_time,
                               .real_time = real_time,
                               .lent = lent,
                               .file = std::nullopt,
                               .now = os::now,
                               .wall_ns = os::wall_ns,
                               .instant_of_wall = os::instant_of_wall};
  if (!options.state_folder.empty() && !lent)
    agent_options.file = DeploymentFile{options.state_folder, options.device, options.domain};
  Agent agent{agent_options,
              {.inspect = inspect,
               .supervise =
                   [&participant, &wake_ups, &options](Supervisor::Options o) {
                     o.participant = *participant;
                     o.wake_ups = wake_ups;
                     o.check_real_time = options.check_real_time;
                     return std::make_unique<Supervisor>(std::move(o));
                   }},
              **voice};

  // What the others say, and then what this node is asked.
  auto devices = dds::Reader<DeviceStatus>::create(
      *participant,
      {.sample =
           [&inbox](const DeviceStatus& status, dds::WriterId writer) {
             inbox.put([status, writer](Agent& a) { a.others().heard(status, writer); });
           },
       .disposed =
           [&inbox](const DeviceStatus& key, dds::WriterId writer) {
             inbox.put([key, writer](Agent& a) { a.others().gone(key, writer); });
           },
       .lost =
           [&inbox](dds::WriterId writer) { inbox.put([writer](Agent& a) { a.others().lost(writer); }); }});
  if (!devices) return refuse(devices.problems());
  auto modules = dds::Reader<LifecycleStatus>::create(
      *participant,
      {.sample =
           [&inbox, &options](const LifecycleStatus& status, dds::WriterId) {
             if (status.device() == options.device) return;
             inbox.put([status](Agent& a) { a.others().heard(status); });
           },
       .disposed = [&inbox](const LifecycleStatus& key,
                            dds::WriterId) { inbox.put([key](Agent& a) { a.others().gone(key); }); },
       .lost = {}});
  if (!modules) return refuse(modules.problems());
  auto server = dds::CommandServer::create(
      *participant, options.device, agent_options.node,
      [&inbox](const dds::WholeCommand& command) { inbox.put([command](Agent& a) { a.hear(command); }); });
  if (!server) return refuse(server.problems());
  (*voice)->answer_by([&server](const dds::WholeReply& reply) { server->reply(reply); });

  if (!lent) log(options.device, "", "waits for a deployment on domain " + std::to_string(options.domain));
  if (options.resume)
    agent.resume();
  else
    agent.leave_kept();
  while (!agent.ended()) {
    (*voice)->sign();
    std::vector<const os::Fd*> fds = agent.wait_on();
    fds.push_back(&signals->fd());
    fds.push_back(&inbox.fd());
    if (lent && !lifetime.closed()) fds.push_back(&lifetime.fd());
    os::wait_readable(fds, kLookEveryMs);

    while (signals->next()) agent.end(false);
    if (lent && !lifetime.closed()) {
      static_cast<void>(lifetime.receive());
      if (lifetime.closed()) agent.end(true);
    }
    inbox.serve(agent);
    agent.step();
  }
  return 0;
}

}  // namespace takt::node
