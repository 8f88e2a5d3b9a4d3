#include "program_process.hpp"

#include <takt/host/component_path.hpp>
#include <takt/host/inspect.hpp>
#include <takt/node/log.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/real_time.hpp>
#include <takt/schedule/levels.hpp>

namespace takt::node {

namespace {

/// Returns the links of a process module as the value of TAKT_LINKS, "PORT=FD,PORT=FD". Adds their file
/// descriptors to `inherit`.
std::string links_of(std::uint32_t module, const supervision::Wiring& wiring,
                     std::vector<const os::Fd*>& inherit) {
  std::string text;
  for (const supervision::Wiring::CreatedLink& created : wiring.links()) {
    const os::Fd& fd = created.memory.memory().fd();
    for (const supervision::LinkEnd* end : {&created.plan.from, &created.plan.to}) {
      if (end->module == module)
        text += (text.empty() ? "" : ",") + end->port + "=" + std::to_string(fd.get());
    }
    if (created.plan.from.module == module || created.plan.to.module == module) inherit.push_back(&fd);
  }
  return text;
}

}  // namespace

Result<void> ProgramProcess::start() {
  os::SpawnOptions options{.program = parts_.paths[module_],
                           .arguments = host::arguments_of(model()),
                           .environment = {},
                           .inherit = {},
                           .cpus = parts_.placement.background,
                           .capture_output = true,
                           .whole_tree = true};
  const bool released = static_cast<bool>(parts_.slots[module_]);
  if (released) {
    Inheritance more = inheritance_();
    options.environment = std::move(more.environment);
    options.inherit = std::move(more.descriptors);
    const os::Fd& slot = parts_.slots[module_].memory().fd();
    const os::Fd& wake_word = parts_.wake_word.memory().fd();
    options.inherit.insert(options.inherit.end(), {&slot, &wake_word});
    // If all process modules share one CPU, they begin their bodies in the order of the table, and use this
    // memory to take turns. On several CPUs, no process module waits for another.
    if (parts_.placement.background.size() == 1 && model().operation == model::Operation::periodic) {
      const os::Fd& turn = parts_.turns[parts_.executor_of(model())].memory().fd();
      options.inherit.push_back(&turn);
      options.environment.emplace_back("TAKT_TURN_FD", std::to_string(turn.get()));
    }
    options.environment.emplace_back("TAKT_SLOT_FD", std::to_string(slot.get()));
    options.environment.emplace_back("TAKT_WAKE_WORD_FD", std::to_string(wake_word.get()));
    options.environment.emplace_back("TAKT_LINKS", links_of(module_, parts_.wiring, options.inherit));
  }
  auto child = host::start_component(std::move(options));
  if (!child) return child.problems();
  child_ = std::move(*child);
  output_ = Output{std::move(child_.output), std::move(child_.error)};
  pid_ = child_.pid();
  if (!released) static_cast<void>(os::make_background(pid_));
  return {};
}

std::optional<supervision::ProcessEnd> ProgramProcess::ended() {
  const auto end = child_.poll();
  if (!end) return std::nullopt;
  step(parts_.of_device().name);
  return end_of(pid_, *end);
}

Result<void> ProgramProcess::make_real_time() {
  const schedule::ExecutorPlan& plan = parts_.plan.executors[parts_.executor_of(model())];
  return os::make_real_time(parts_.slots[module_][0].thread.load(),
                            schedule::program_level(parts_.of_device(), plan, module_));
}

void ProgramProcess::wake_for_property() {
  os::futex_wake(parts_.slots[module_][0].property_request.number, ~0U);
}

void ProgramProcess::step(const std::string& device) {
  output_.read([&](const std::string& line) { log(device, model().name, "| " + line); });
}

void ProgramProcess::wait_on(std::vector<const os::Fd*>& fds) const {
  fds.insert(fds.end(), {&output_.output(), &output_.error()});
}

}  // namespace takt::node
