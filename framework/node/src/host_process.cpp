#include "host_process.hpp"

#include <algorithm>

#include <takt/host/component_path.hpp>
#include <takt/node/log.hpp>
#include <takt/node/violations.hpp>
#include <takt/os/core_dump.hpp>
#include <takt/os/sealed_copy.hpp>

namespace takt::node {

namespace {

/// Returns the links of a host's modules, for the host's setup. Adds their file descriptors to `inherit`.
std::vector<host::PortLink> links_of(const model::HostShare& share, const supervision::Wiring& wiring,
                                     std::vector<const os::Fd*>& inherit) {
  std::vector<host::PortLink> ends;
  for (const supervision::Wiring::CreatedLink& created : wiring.links()) {
    const std::size_t before = ends.size();
    for (const supervision::LinkEnd* end : {&created.plan.from, &created.plan.to}) {
      if (!end->module || std::count(share.modules.begin(), share.modules.end(), *end->module) == 0) continue;
      ends.push_back({*end->module, end->port, created.memory.memory().fd().get(), created.plan.typed,
                      end == &created.plan.to && created.plan.stale == model::Stale::error});
    }
    if (ends.size() > before) inherit.push_back(&created.memory.memory().fd());
  }
  return ends;
}

}  // namespace

supervision::ProcessEnd end_of(int pid, const os::ProcessEnd& end) {
  const os::CoreDump core = end.signalled ? os::find_core_dump(pid, end.code) : os::CoreDump{};
  return {.text = end.text(),
          .signalled = end.signalled,
          .code = end.code,
          .core = core.file,
          .no_core = core.why};
}

Result<void> HostProcess::start() {
  auto sockets = os::MessageSocket::pair();
  if (!sockets) return sockets.problems();
  socket_ = std::move(sockets->first);
  swapped_.clear();
  unloadable_.clear();
  os::MessageSocket theirs = std::move(sockets->second);

  Inheritance more = inheritance_();
  std::vector<const os::Fd*>& inherit = more.descriptors;
  const os::Fd& wake_word = parts_.wake_word.memory().fd();
  const os::Fd& saved = parts_.saved.memory().fd();
  inherit.insert(inherit.end(), {&wake_word, &saved, &theirs.fd(), &parts_.channel.fd()});
  const model::HostShare& share = parts_.shares[share_];
  host::Setup setup{.device = parts_.of_device(),
                    .share = share_,
                    .paths = parts_.paths,
                    .executor_cpus = parts_.placement.executors,
                    .background_cpus = parts_.placement.background,
                    .slot_fds = {},
                    .wake_word_fd = wake_word.get(),
                    .saved_fd = saved.get(),
                    .links = links_of(share, parts_.wiring, inherit)};
  for (std::uint32_t i = 0; i < parts_.slots.size(); ++i) {
    const bool released = parts_.slots[i] && std::count(share.programs.begin(), share.programs.end(), i) != 0;
    setup.slot_fds.push_back(released ? parts_.slots[i].memory().fd().get() : -1);
    if (released) inherit.push_back(&parts_.slots[i].memory().fd());
  }

  os::SpawnOptions options{.program = os::private_directory() + "/takt-host",
                           .arguments = {},
                           .environment = {{"TAKT_NODE_FD", std::to_string(theirs.fd().get())},
                                           {"TAKT_CHANNEL_FD", std::to_string(parts_.channel.fd().get())}},
                           .inherit = inherit,
                           .capture_output = true,
                           .dies_with_parent = false};  // the host shuts down when its socket closes
  options.environment.insert(options.environment.end(), more.environment.begin(), more.environment.end());
  auto child = os::Child::spawn(options);
  if (!child) return child.problems();
  child_ = std::move(*child);
  pid_ = child_.pid();
  output_ = Output{std::move(child_.output), std::move(child_.error)};
  // If this fails because the host has ended, ended() reports the end.
  static_cast<void>(socket_.send(host::encode(setup)));
  return {};
}

Result<HostProcess::Component> HostProcess::open(const std::string& path) {
  auto copy = host::open_component(path);
  if (!copy) return copy.problems();
  const bool is_signed = static_cast<bool>(*copy);
  if (!is_signed) copy = os::sealed_copy(path);
  if (!copy) return copy.problems();
  return Component{path, std::make_shared<const os::Fd>(std::move(*copy)), is_signed};
}

// A restarted host and a module that recovers load the component that was deployed, even if its file has
// been replaced since, for example in preparation of an update. All modules of one file are deployed with the
// same content.
Result<HostProcess::Component> HostProcess::component_of(const host::Request& request) {
  const bool swaps = request.what == host::Request::Do::swap;
  const std::string& path = swaps ? request.value : parts_.paths[request.module];
  Component& kept = (swaps ? swapped_ : components_)[request.module];
  if (kept.copy != nullptr && !swaps && !request.afresh) return kept;
  if (!swaps && !request.afresh) {
    for (const auto& [module, other] : components_) {
      if (other.copy != nullptr && other.path == path) return kept = other;
    }
  }
  auto opened = open(path);
  if (opened) kept = *opened;
  return opened;
}

bool HostProcess::ask(const host::Request& request) {
  const bool loads = request.what == host::Request::Do::swap ||
                     (request.what == host::Request::Do::call && request.hook == channel::Doing::load);
  if (!loads) return socket_.send(host::encode(request));
  auto component = component_of(request);
  if (!component) {
    unloadable_.push_back(
        {.request = request, .ok = false, .text = in_words(component.problems()), .warnings = {}});
    return true;
  }
  host::Request with_component = request;
  with_component.is_signed = component->is_signed;
  return socket_.send(host::encode(with_component), std::move(component->copy));
}

std::optional<host::Answer> HostProcess::answer() {
  if (!unloadable_.empty()) {
    host::Answer answer = std::move(unloadable_.front());
    unloadable_.pop_front();
    return answer;
  }
  while (auto text = socket_.receive()) {
    auto answer = host::decode_answer(*text);
    if (!answer) continue;
    if (answer->request.what == host::Request::Do::swap) {
      const auto swapped = swapped_.extract(answer->request.module);
      if (answer->ok && !swapped.empty()) components_[swapped.key()] = std::move(swapped.mapped());
    }
    return std::move(*answer);
  }
  return std::nullopt;
}

std::optional<supervision::ProcessEnd> HostProcess::ended() {
  const auto end = child_.poll();
  if (!end) return std::nullopt;
  step(parts_.of_device().name);
  return end_of(pid_, *end);
}

supervision::CrashCalls HostProcess::calls_of_crash(std::uint32_t module) {
  constexpr std::size_t kShown = 5;
  const channel::Crash& crash = parts_.channel.host(share_).crash;
  // The acquire load pairs with the host's release stores, so all frames below `depth` are complete.
  const std::uint32_t depth =
      std::min<std::uint32_t>(crash.depth.load(std::memory_order_acquire), channel::Crash::kFrames);
  if (!symbols_) symbols_.emplace();
  const std::string host = os::private_directory() + "/takt-host";
  std::vector<std::string> objects;
  for (std::uint32_t i = 0; i < depth; ++i) {
    std::string object{crash.frames[i].object.view()};
    if (object.empty()) object = host;
    // While a component is loaded, its name is that of its copy in memory.
    if (object.starts_with("/proc/")) object = parts_.paths.at(module);
    objects.push_back(std::move(object));
  }
  std::vector<std::string> calls;
  for (std::size_t i = 0; i < calls_of_module(objects, host); ++i)
    calls.push_back(symbols_->name(objects[i], crash.frames[i].address));
  const std::string text = called_by(calls, kShown);
  if (text.empty()) return {};
  const std::size_t end = std::min(text.find(", called by "), text.size());
  return {.place = ", " + text.substr(0, end), .callers = text.substr(end)};
}

void HostProcess::step(const std::string& device) {
  socket_.flush();
  const model::HostShare& share = parts_.shares[share_];
  const std::string name = share.is_own() ? "(host " + share.name + ")" : "(host)";
  output_.read([&](const std::string& line) { log(device, name, line); });
}

void HostProcess::wait_on(std::vector<const os::Fd*>& fds) const {
  if (!running()) return;
  fds.insert(fds.end(), {&output_.output(), &output_.error()});
  // A closed socket would wake the node's main loop all the time.
  if (!socket_.closed()) fds.push_back(&socket_.fd());
}

}  // namespace takt::node
