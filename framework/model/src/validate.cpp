#include <takt/model/validate.hpp>

#include <algorithm>
#include <map>
#include <utility>

#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>
#include <takt/model/findings.hpp>
#include "validate_network.hpp"

namespace takt::model {

namespace {

class Validation {
 public:
  Validation(const Cell& cell, const Gaps& gaps, Findings& findings)
      : cell_(cell), gaps_(gaps), findings_(findings) {
    gaps_.of_device.resize(cell.devices.size());
  }

  void run();

 private:
  using OfDevice = Gaps::OfDevice;

  void add(Line line, std::string what, std::string fix) {
    findings_.add(line, std::move(what), std::move(fix));
  }
  template <class Named>
  bool check_names(const char* kind, const std::vector<Named>& all, const std::string& owner,
                   const char* cure = "give one of them another name");
  void check_device(const Device& device, OfDevice& gaps);
  void check_module_names(const Device& device, OfDevice& gaps);
  void check_executor(const Executor& executor);
  void check_module(const Module& module, const Device& device, const OfDevice& gaps);
  void check_times(const Module& module);
  void check_release(const Module& module);
  void check_arguments(const Module& module);
  void check_log_level(const Module& module);
  void check_executor_of(const Module& module, const Device& device, const OfDevice& gaps);

  const Cell& cell_;
  Gaps gaps_;
  Findings& findings_;
};

/// Checks that the names of all elements in a list are valid and unique. Returns false if a name is not
/// valid or occurs twice; then references to that element cannot be checked. `cure`: what to do about a
/// duplicate.
template <class Named>
bool Validation::check_names(const char* kind, const std::vector<Named>& all, const std::string& owner,
                             const char* cure) {
  bool usable = true;
  std::map<std::string_view, const Named*> first;
  for (const Named& one : all) {
    if (!is_valid_name(one.name)) {
      add(one.line, in_quotes(one.name) + " is not a valid " + kind + " name", kNameRule);
      usable = false;
      continue;
    }
    const auto [seen, is_new] = first.emplace(one.name, &one);
    if (is_new) continue;
    add(one.line, "duplicate " + std::string{kind} + " " + in_quotes(one.name) + owner,
        "the first is " + findings_.whereabouts(seen->second->line) + "; " + cure);
    usable = false;
  }
  return usable;
}

void Validation::check_module_names(const Device& device, OfDevice& gaps) {
  std::map<std::string_view, const Module*> first;
  for (const Module& module : device.modules) {
    const bool from_file = !module.lines.name.given() && module.name == file_stem(module.filename);
    const Line line = module.lines.name.given() ? module.lines.name : module.line;
    if (!is_valid_name(module.name)) {
      gaps.modules = true;
      if (from_file && module.filename.empty()) {
        continue;  // check_module() reports an empty filename
      } else if (from_file) {
        add(line, in_quotes(module.name) + ", taken from the filename, is not a valid module name",
            std::string{"give the module a <name>; "} + kNameRule);
      } else {
        add(line, in_quotes(module.name) + " is not a valid module name", kNameRule);
      }
      continue;
    }
    const auto [seen, is_new] = first.emplace(module.name, &module);
    if (is_new) continue;
    gaps.modules = true;  // a reference may mean the name that one of the two should have
    add(line, "duplicate module " + in_quotes(module.name) + " on device " + in_quotes(device.name),
        "the first is " + findings_.whereabouts(seen->second->line) +
            (from_file ? "; give one of them a <name>: this name is taken from the filename"
                       : "; give one of them another <name>"));
  }
}

void Validation::check_executor(const Executor& executor) {
  if (executor.priority < kMinExecutorPriority || executor.priority > kMaxExecutorPriority) {
    add(executor.line,
        "executor " + in_quotes(executor.name) + " has priority " + std::to_string(executor.priority),
        "the priority of an executor must be from 2 to 98");
  }
  if (executor.cpu && (*executor.cpu < 0 || *executor.cpu > kMaxCpu)) {
    add(executor.line, "executor " + in_quotes(executor.name) + " has cpu " + std::to_string(*executor.cpu),
        "a CPU number must be from 0 to 1023");
  }
}

void Validation::check_times(const Module& module) {
  const std::string name = in_quotes(module.name);
  const auto or_module = [&](Line line) { return line.given() ? line : module.line; };
  const Line period_line = or_module(module.lines.period);
  const Line deadline_line = or_module(module.lines.deadline);
  const auto at_least = [&](Nanoseconds least, const char* what, const std::optional<Nanoseconds>& time,
                            Line line) {
    if (!time || *time >= least) return;
    add(line, "module " + name + " has a " + what + " of " + std::to_string(time->count()) + " ns",
        std::string{"a "} + what + " must be at least " + takt::to_text(least));
  };
  at_least(kMinPeriod, "period", module.period, period_line);
  at_least(Nanoseconds{1}, "deadline", module.deadline, deadline_line);
  at_least(Nanoseconds{1}, "budget", module.budget, or_module(module.lines.budget));

  if (module.offset && module.operation != Operation::periodic) {
    add(or_module(module.lines.offset),
        to_text(module.operation) + std::string{" module "} + name + " has an <offset>",
        "remove the <offset>, or make the module periodic: only periodic modules have an offset");
  } else if (module.offset && module.period &&
             (module.offset->count() < 0 || *module.offset >= *module.period)) {
    add(or_module(module.lines.offset),
        "the offset of " + name + ", " + takt::to_text(*module.offset) + ", is outside its period, " +
            takt::to_text(*module.period),
        "an offset must be at least 0 and less than the period");
  }
  if (module.overrun && module.operation != Operation::periodic) {
    add(or_module(module.lines.overrun),
        to_text(module.operation) + std::string{" module "} + name + " has an <overrun>",
        module.operation == Operation::sporadic
            ? "remove the <overrun>, and set the reaction to a missed deadline with miss=\"...\" on the "
              "<deadline>"
            : "remove the <overrun>: only periodic modules have an overrun contract");
  }
  const auto tolerated = [&](const char* what, const std::optional<int>& number) {
    if (!number || (*number >= 1 && *number <= kMaxTolerance)) return;
    add(or_module(module.lines.budget),
        "the budget of " + name + " has " + what + " " + std::to_string(*number),
        std::string{what} + " must be from 1 to 1000");
  };
  tolerated("times", module.tolerance.times);
  tolerated("in-a-row", module.tolerance.in_a_row);
  const int budgets = std::max(1, module.tolerance.times.value_or(1));
  if (module.hang && module.budget && *module.hang / budgets <= *module.budget) {
    add(or_module(module.lines.budget),
        "a run of " + name + " hangs after " + takt::to_text(*module.hang) + ", but may take " +
            (budgets == 1 ? "" : std::to_string(budgets) + " times ") + takt::to_text(*module.budget),
        "set hang to a longer time than the budget allows, or remove it");
  }

  switch (module.operation) {
    case Operation::periodic:
      if (!module.period) {
        add(module.line, "periodic module " + name + " has no <period>",
            "add one, as in <period>1ms</period>");
      }
      if (module.deadline) {
        add(deadline_line, "periodic module " + name + " has a <deadline>",
            "its period is its deadline: remove the <deadline>, or make the module sporadic");
      }
      break;
    case Operation::sporadic:
      if (!module.deadline) {
        add(module.line, "sporadic module " + name + " has no <deadline>",
            "add one, as in <deadline>1ms</deadline>");
      }
      if (module.period) {
        add(period_line, "sporadic module " + name + " has a <period>",
            "remove the <period>, or make the module periodic");
      }
      break;
    case Operation::non_real:
      if (module.period && module.type != ModuleType::thread) {
        add(period_line, "non-real module " + name + " is a process and has a <period>",
            "remove the <period>: Takt does not release a non-real process");
      }
      if (module.deadline) {
        add(deadline_line, "non-real module " + name + " has a <deadline>",
            "remove the <deadline>, or make the module sporadic");
      }
      if (module.budget) {
        add(or_module(module.lines.budget), "non-real module " + name + " has a <budget>",
            "remove the <budget>: only periodic and sporadic modules have a budget");
      }
      break;
  }
}

/// Checks the interarrival time and <retain> of a module, and rejects elements that only a sporadic module
/// may have.
void Validation::check_release(const Module& module) {
  const std::string name = in_quotes(module.name);
  const auto or_module = [&](Line line) { return line.given() ? line : module.line; };
  if (module.interarrival && module.interarrival->count() <= 0) {
    add(or_module(module.lines.interarrival),
        "module " + name + " has an interarrival of " + std::to_string(module.interarrival->count()) + " ns",
        "an interarrival must be at least 1 ns");
  }
  if (module.retain && module.type == ModuleType::process && module.operation == Operation::non_real) {
    add(or_module(module.lines.retain), "non-real process " + name + " has a <retain>",
        "remove the <retain>: a non-real process keeps its state in its own files");
  }
  if (module.operation == Operation::sporadic) return;
  const std::string kind = std::string{to_text(module.operation)} + " module " + name;
  const std::string reason = module.operation == Operation::periodic
                                 ? ": a periodic module is released by its period"
                                 : ": a non-real module runs outside the scheduler";
  if (module.lines.dispatch.given() || module.dispatch != Dispatch::row) {
    add(or_module(module.lines.dispatch), kind + " has a <dispatch>",
        "remove the <dispatch>, or make the module sporadic" + reason);
  }
  if (module.interarrival) {
    add(or_module(module.lines.interarrival), kind + " has an <interarrival>",
        "remove the <interarrival>, or make the module sporadic" + reason);
  }
  // If the module has a deadline, check_times() has already rejected the deadline, so do not also report
  // `miss`.
  if (module.miss != Miss::count && !module.deadline) {
    add(module.line, kind + " has a reaction to a missed deadline, but no deadline",
        "remove miss, or make the module sporadic");
  }
}

void Validation::check_arguments(const Module& module) {
  if (module.arguments.empty()) return;
  const Line line = module.lines.arguments.given() ? module.lines.arguments : module.line;
  const std::string name = in_quotes(module.name);
  if (module.type == ModuleType::thread) {
    add(line, "thread module " + name + " has <arguments>",
        "use <property>: only a program, a process module, has arguments");
  }
  if (module.arguments.size() > kMaxArguments) {
    add(line, "module " + name + " has " + std::to_string(module.arguments.size()) + " arguments",
        "at most " + std::to_string(kMaxArguments) + " arguments are allowed");
  }
  for (const std::string& argument : module.arguments) {
    if (argument.size() > kMaxArgument) {
      add(line, "module " + name + " has an argument of " + std::to_string(argument.size()) + " bytes",
          "at most " + std::to_string(kMaxArgument) + " bytes are allowed");
    } else if (argument.find('\0') != std::string::npos) {
      add(line, "an argument of module " + name + " contains a zero byte", "remove the zero byte");
    }
  }
}

void Validation::check_log_level(const Module& module) {
  for (const PropertyValue& property : module.properties) {
    if (property.name != kLogLevelProperty) continue;
    const std::string name = "module " + in_quotes(module.name);
    if (!has_log(module)) {
      add(property.line,
          name + " is a program without releases, which has no log, but sets property 'log-level'",
          "remove the property, and let the program print its lines");
    } else if (const auto level = log_level_from(property.value); !level) {
      add(property.line, name + ": " + level.problems()[0].what, level.problems()[0].fix);
    }
  }
}

void Validation::check_executor_of(const Module& module, const Device& device, const OfDevice& gaps) {
  const Line line = module.lines.executor.given() ? module.lines.executor : module.line;
  if (module.operation == Operation::non_real) {
    if (module.executor.empty()) return;
    add(line, "non-real module " + in_quotes(module.name) + " has an <executor>",
        "remove the <executor>: a non-real module runs outside the scheduler");
    return;
  }
  if (gaps.executors || device.executors.empty()) return;
  const std::vector<std::string_view> names = names_of(device.executors);
  if (module.executor.empty()) {
    add(line,
        "module " + in_quotes(module.name) + " has no <executor>, and its device has " +
            std::to_string(names.size()) + " executors",
        "name one: " + one_of(names));
    return;
  }
  if (std::find(names.begin(), names.end(), module.executor) != names.end()) return;
  const std::string_view meant = nearest(module.executor, names);
  const std::string guess = meant.empty() ? "" : "did you mean " + brief(meant) + "? ";
  add(line, "unknown executor " + in_quotes(module.executor) + " of module " + in_quotes(module.name),
      guess + "device " + in_quotes(device.name) + " has " + one_of(names));
}

void Validation::check_module(const Module& module, const Device& device, const OfDevice& gaps) {
  const Line filename_line = module.lines.filename.given() ? module.lines.filename : module.line;
  if (module.filename.empty()) {
    add(filename_line, "module " + in_quotes(module.name) + " has an empty filename",
        "give the path of the module's .so or program");
  } else if (module.filename.size() > kMaxFilename) {
    add(filename_line, "the filename " + in_quotes(module.filename) + " is too long",
        "at most 4096 bytes are allowed");
  } else if (module.filename.find('\0') != std::string::npos) {
    add(filename_line, "the filename " + in_quotes(module.filename) + " contains a zero byte",
        "remove the zero byte");
  }
  check_times(module);
  check_release(module);
  check_executor_of(module, device, gaps);

  const Recovery& recovery = module.recovery;
  if (recovery.attempts < 0 || recovery.attempts > kMaxAttempts) {
    add(module.line,
        "module " + in_quotes(module.name) + " has " + std::to_string(recovery.attempts) +
            " recovery attempts",
        "attempts must be from 0 to 1000");
  }
  if (recovery.backoff.count() < 0 || recovery.backoff > kMaxBackoff) {
    add(module.line,
        "module " + in_quotes(module.name) + " has a backoff of " + takt::to_text(recovery.backoff),
        "backoff must be from 0 to 3600000000000 ns (1 h)");
  }
  check_arguments(module);
  const char* remove = "remove one of them";  // the component decides the names
  check_names("property", module.properties, " of module " + in_quotes(module.name), remove);
  check_log_level(module);
  check_names("port", module.safe, " in <safe> of module " + in_quotes(module.name), remove);
}

void Validation::check_device(const Device& device, OfDevice& gaps) {
  const auto too_many = [&](std::size_t number, std::size_t most, const char* what) {
    if (number <= most) return;
    add(device.line, "device " + in_quotes(device.name) + " has " + std::to_string(number) + " " + what,
        "a device has at most " + std::to_string(most) + " " + what);
  };
  too_many(device.executors.size(), kMaxExecutors, "executors");
  too_many(device.modules.size(), kMaxModules, "modules");
  if (device.executors.empty() && !gaps.executors) {
    add(device.line, "device " + in_quotes(device.name) + " has no executor", "add an <executor>");
  }
  if (device.modules.empty() && !gaps.modules) {
    add(device.line, "device " + in_quotes(device.name) + " has no module", "give it at least one <module>");
  }
  if (!check_names("executor", device.executors, " on device " + in_quotes(device.name)))
    gaps.executors = true;
  check_module_names(device, gaps);
  if (device.executors.size() > kMaxExecutors)
    // Do not look up the executor of every module: with so many executors, this would take hours.
    gaps.executors = true;
  for (const Executor& executor : device.executors) check_executor(executor);
  for (const Module& module : device.modules) {
    if (findings_.full()) return;
    check_module(module, device, gaps);
  }
}

void Validation::run() {
  if (!is_valid_name(cell_.name))
    add(cell_.line, in_quotes(cell_.name) + " is not a valid cell name", kNameRule);
  if (cell_.domain < 0 || cell_.domain > kMaxDomain) {
    add(cell_.line, "the cell has domain " + std::to_string(cell_.domain), "a domain must be from 0 to 232");
  }
  if (cell_.devices.empty() && !gaps_.devices)
    add(cell_.line, "the cell has no device", "give it at least one <device>");
  if (cell_.devices.size() > kMaxDevices) {
    add(cell_.line, "the cell has " + std::to_string(cell_.devices.size()) + " devices",
        "a cell has at most 1000 devices");
  }
  if (!check_names("device", cell_.devices, " in cell " + in_quotes(cell_.name))) gaps_.devices = true;
  for (std::size_t i = 0; i < cell_.devices.size(); ++i) check_device(cell_.devices[i], gaps_.of_device[i]);
  validate_network(cell_, gaps_, findings_);
}

}  // namespace

Problems validate(const Cell& cell) { return validate(cell, {}); }
Problems validate(const Cell& cell, const Gaps& gaps) {
  Findings findings{cell};
  validate(cell, gaps, findings);
  return findings.take();
}
void validate(const Cell& cell, const Gaps& gaps, Findings& findings) {
  Validation{cell, gaps, findings}.run();
}

}  // namespace takt::model
