#include <takt/node/host_link.hpp>

namespace takt::node {

Result<void> HostLink::start(const channel::Channel& channel, const host::Setup& setup,
                             const std::vector<const os::Fd*>& inherit,
                             const std::vector<std::pair<std::string, std::string>>& environment) {
  auto sockets = os::MessageSocket::pair();
  if (!sockets) return sockets.problems();
  socket_ = std::move(sockets->first);
  os::MessageSocket theirs = std::move(sockets->second);

  os::SpawnOptions options{.program = os::private_directory() + "/takt-host",
                           .arguments = {},
                           .environment = {{"TAKT_NODE_FD", std::to_string(theirs.fd().get())},
                                           {"TAKT_CHANNEL_FD", std::to_string(channel.fd().get())}},
                           .inherit = inherit,
                           .capture_output = true,
                           .dies_with_parent = false};  // it shuts down when its socket closes
  options.environment.insert(options.environment.end(), environment.begin(), environment.end());
  options.inherit.push_back(&theirs.fd());
  options.inherit.push_back(&channel.fd());
  auto child = os::Child::spawn(options);
  if (!child) return child.problems();
  child_ = std::move(*child);
  pid_ = child_.pid();
  output_ = Output{std::move(child_.output), std::move(child_.error)};
  static_cast<void>(socket_.send(host::encode(setup)));  // if it has already ended, ended() tells how
  return {};
}

std::optional<host::Answer> HostLink::answer() {
  while (auto text = socket_.receive()) {
    if (auto answer = host::decode_answer(*text)) return std::move(*answer);
  }
  return std::nullopt;
}

void HostLink::kill() const noexcept { child_.signal(os::kKill); }

}  // namespace takt::node
