#include <takt/model/difference.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>

namespace takt::model {

const char* to_text(Change change) {
  switch (change) {
    case Change::none:
      return "none";
    case Change::in_place:
      return "in place";
    case Change::anew:
      return "anew";
    case Change::added:
      return "added";
    case Change::removed:
      return "removed";
  }
  return "?";
}

namespace {

std::string words(bool value) { return value ? "yes" : "no"; }
std::string words(int value) { return std::to_string(value); }
std::string words(double value) {
  std::array<char, 32> buffer{};
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}
std::string words(const std::string& text) { return text.empty() ? "none" : text; }
std::string words(Nanoseconds time) { return takt::to_text(time); }
std::string words(const OverrunContract& contract) {
  const std::string what = to_text(contract.what);
  return contract.what == Overrun::catch_up ? what + " " + words(contract.limit) : what;
}
std::string words(const Recovery& recovery) {
  return words(recovery.attempts) + " attempts, backoff " + words(recovery.backoff) + ", then " +
         to_text(recovery.then);
}
template <class T>
std::string words(const std::optional<T>& value) {
  return value ? words(*value) : "none";
}
std::string words(const BudgetTolerance& tolerance) {
  return "times " + words(tolerance.times) + ", in a row " + words(tolerance.in_a_row);
}
std::string words(const SafeValue& safe) {
  std::string text = safe.name + " {";
  for (const PropertyValue& field : safe.fields)
    text += (text.back() == '{' ? "" : ", ") + field.name + ": " + field.value;
  return text + "}";
}
std::string words(const std::vector<SafeValue>& all) {
  std::string text;
  for (const SafeValue& safe : all) text += (text.empty() ? "" : " ") + words(safe);
  return words(text);
}

std::string from_to(const std::string& what, const std::string& before, const std::string& after) {
  return what + ": " + before + " -> " + after;
}

/// An executor, module or connection of a device, with its name and all its settings as text. Equal settings
/// have equal texts.
struct Part {
  std::string name;
  std::vector<std::pair<const char*, std::string>> facets;
};

// Each part_of() names all members of its struct in a structured binding. So if a member is added to the
// struct, part_of() does not compile until it compares the new member, too.
Part part_of(const Executor& executor) {
  const auto& [name, cpu, priority, rate_monotonic, wakeup, spin_share, overrun, offsets, timing, own_host,
               line] = executor;
  return {"executor " + name,
          {{"cpu", words(cpu)},
           {"priority", words(priority)},
           {"rate-monotonic", words(rate_monotonic)},
           {"wakeup", to_text(wakeup)},
           {"spin", words(spin_share)},
           {"overrun", words(overrun)},
           {"offsets", to_text(offsets)},
           {"timing", to_text(timing)},
           {"own host", words(own_host)}}};
}

// Omits the filename and the properties of the module, because compare_contents() compares them.
Part part_of(const Module& module) {
  const auto& [name, filename, type, operation, period, offset, deadline, miss, dispatch, interarrival,
               priority, executor, budget, tolerance, hang, overrun, recovery, retain, arguments, properties,
               safe, line, lines] = module;
  return {"module " + name,
          {{"moduletype", to_text(type)},
           {"operationtype", to_text(operation)},
           {"period", words(period)},
           {"offset", words(offset)},
           {"deadline", words(deadline)},
           {"miss", to_text(miss)},
           {"dispatch", to_text(dispatch)},
           {"interarrival", words(interarrival)},
           {"priority", words(priority)},
           {"executor", words(executor)},
           {"budget", words(budget)},
           {"budget tolerance", words(tolerance)},
           {"hang", words(hang)},
           {"overrun", words(overrun)},
           {"recovery", words(recovery)},
           {"retain", words(retain)},
           {"arguments", words(in_one_line(arguments))},
           {"safe", words(safe)}}};
}

std::string words_of(const Endpoint& end, const Connection& connection) {
  return end.given() ? to_text(end) : "topic " + connection.topic;
}

/// Returns the safe value that the descriptor sets for the writer of a connection, as text. A changed safe
/// value counts as a change of the connection, because the reader's device also uses the value.
std::string safe_of(const Cell& cell, const Endpoint& from) {
  for (const Device& device : cell.devices) {
    for (const Module& module : device.modules) {
      if (device.name != from.device || module.name != from.module) continue;
      for (const SafeValue& safe : module.safe) {
        if (safe.name == from.port) return words(safe);
      }
    }
  }
  return "none";
}

Part part_of(const Connection& connection, const Cell& cell) {
  const auto& [from, to, kind, depth, depth_given, reliability, deadline, lifespan, stale, topic, domain,
               ros2, carries, line] = connection;
  return {"connection " + words_of(from, connection) + " -> " + words_of(to, connection),
          {{"kind", to_text(kind)},
           {"depth", words(depth)},
           {"reliability", to_text(reliability)},
           {"deadline", words(deadline)},
           {"lifespan", words(lifespan)},
           {"stale", to_text(stale)},
           {"topic", words(topic)},
           {"domain", words(domain)},
           {"ROS 2", words(ros2)},
           {"carries", to_text(carries)},
           {"safe", safe_of(cell, from)}}};
}

template <class All>
std::vector<Part> parts_of(const All& all) {
  std::vector<Part> parts;
  for (const auto& one : all) parts.push_back(part_of(one));
  return parts;
}
std::vector<Part> connections_of(const Device& device, const Cell& cell) {
  std::vector<Part> parts;
  for (const Connection& connection : cell.connections) {
    if (connection.from.device == device.name || connection.to.device == device.name)
      parts.push_back(part_of(connection, cell));
  }
  return parts;
}

const Part* find_part(const std::vector<Part>& parts, const std::string& name) {
  const auto found =
      std::find_if(parts.begin(), parts.end(), [&name](const Part& part) { return part.name == name; });
  return found == parts.end() ? nullptr : &*found;
}

void compare(const std::vector<Part>& before, const std::vector<Part>& after,
             std::vector<std::string>& reasons) {
  for (const Part& part : after) {
    const Part* const was = find_part(before, part.name);
    if (was == nullptr) reasons.push_back(part.name + " is new");
    for (std::size_t i = 0; was != nullptr && i < part.facets.size(); ++i) {
      if (was->facets[i] != part.facets[i])
        reasons.push_back(part.name + ": " +
                          from_to(part.facets[i].first, was->facets[i].second, part.facets[i].second));
    }
  }
  for (const Part& part : before) {
    if (find_part(after, part.name) == nullptr) reasons.push_back(part.name + " is removed");
  }
}

// Adds a reason if the order of elements in the descriptor has changed. This order decides which of two
// modules of equal priority runs first, and which CPU an executor gets.
void compare_order(const std::vector<Part>& before, const std::vector<Part>& after, const char* what,
                   std::vector<std::string>& reasons) {
  const auto same = [](const Part& one, const Part& other) { return one.name == other.name; };
  if (std::is_permutation(before.begin(), before.end(), after.begin(), after.end(), same) &&
      !std::equal(before.begin(), before.end(), after.begin(), after.end(), same))
    reasons.push_back(std::string{"the order of the "} + what + " has changed");
}

bool can_swap(const Module& module) {
  return module.type == ModuleType::thread && module.operation == Operation::periodic;
}

// Compares the file and the properties of a module. Adds each difference to the changes that can be made
// while the module runs, or to the reasons for a restart of the device.
void compare_contents(const Module& before, const Module& after, DeviceDifference& difference) {
  const bool thread = after.type == ModuleType::thread;
  const auto reason = [&](const std::string& words) {
    difference.reasons.push_back("module " + after.name + ": " + words);
  };
  for (const PropertyValue& given : after.properties) {
    const auto was = given_property(before, given.name);
    if (was && *was == given.value) continue;
    const std::string words = from_to(given.name, was ? brief(*was) : "not set", brief(given.value));
    if (thread || given.name == kLogLevelProperty)
      difference.in_place.push_back({after.name, given.name, given.value, words});
    else
      reason(words);
  }
  for (const PropertyValue& given : before.properties) {
    if (given_property(after, given.name)) continue;
    if (given.name == kLogLevelProperty) {
      const std::string level = takt::to_text(kDefaultLogLevel);
      difference.in_place.push_back(
          {after.name, given.name, level, from_to(given.name, brief(given.value), level + ", the default")});
    } else {
      reason(given.name + " is no longer set");
    }
  }
  if (before.filename == after.filename) return;
  const std::string words = from_to("file", before.filename, after.filename);
  if (can_swap(after))
    difference.in_place.push_back({after.name, "", after.filename, words});
  else
    reason(words);
}

const Device* find_device(const Cell& cell, const std::string& name) {
  const auto found = std::find_if(cell.devices.begin(), cell.devices.end(),
                                  [&name](const Device& device) { return device.name == name; });
  return found == cell.devices.end() ? nullptr : &*found;
}

DeviceDifference difference_of(const Cell& cell_before, const Device& before, const Cell& cell_after,
                               const Device& after) {
  DeviceDifference difference{.device = after.name};
  const auto executors = std::pair{parts_of(before.executors), parts_of(after.executors)};
  const auto modules = std::pair{parts_of(before.modules), parts_of(after.modules)};
  compare(executors.first, executors.second, difference.reasons);
  compare_order(executors.first, executors.second, "executors", difference.reasons);
  compare(modules.first, modules.second, difference.reasons);
  compare_order(modules.first, modules.second, "modules", difference.reasons);
  for (const Module& module : after.modules) {
    const auto was = std::find_if(before.modules.begin(), before.modules.end(),
                                  [&module](const Module& one) { return one.name == module.name; });
    if (was != before.modules.end()) compare_contents(*was, module, difference);
  }
  compare(connections_of(before, cell_before), connections_of(after, cell_after), difference.reasons);
  if (!difference.reasons.empty()) {
    const std::string first = std::move(difference.reasons.front());
    difference.reasons.erase(difference.reasons.begin());
    difference.make_anew(first);
  } else if (!difference.in_place.empty()) {
    difference.change = Change::in_place;
  }
  return difference;
}

std::string words(const Discovery& discovery) {
  std::string text = to_text(discovery.kind);
  for (const std::string& peer : discovery.peers) text += " " + peer;
  return discovery.server.empty() ? text : text + " " + discovery.server;
}

Problems check_cell_values(const Cell& before, const Cell& after) {
  const auto domain = [](const Cell& cell) {
    return cell.domain_given ? std::to_string(cell.domain) : std::string{"none"};
  };
  const std::array<std::array<std::string, 3>, 5> all{{
      {"name", before.name, after.name},
      {"domain", domain(before), domain(after)},
      {"discovery", words(before.discovery), words(after.discovery)},
      {"discovery server device", words(before.server_device), words(after.server_device)},
      {"required security", words(before.security_required), words(after.security_required)},
  }};
  Problems problems;
  for (const auto& [what, was, is] : all) {
    if (was == is) continue;
    problems.push_back(problem_at(after.texts(), after.line,
                                  "a running cell cannot change its " + from_to(what, was, is),
                                  "undeploy the cell and deploy it again"));
  }
  return problems;
}

}  // namespace

void DeviceDifference::make_anew(const std::string& why) {
  change = Change::anew;
  reasons.insert(reasons.begin(), why);
  for (const ModuleChange& one : in_place) reasons.push_back("module " + one.module + ": " + one.words);
  in_place.clear();
}

void DeviceDifference::add_file(const Module& module, const std::string& file, const std::string& words) {
  const std::string why = "module " + module.name + ": " + words;
  if (change == Change::anew) {
    reasons.push_back(why);
  } else if (can_swap(module)) {
    in_place.push_back({module.name, "", file, words});
    change = Change::in_place;
  } else {
    make_anew(why);
  }
}

std::vector<std::string> in_words(const DeviceDifference& difference) {
  std::vector<std::string> lines;
  switch (difference.change) {
    case Change::none:
      break;
    case Change::in_place:
      for (const ModuleChange& one : difference.in_place) {
        const std::string module = difference.device + "." + one.module + ": ";
        if (!lines.empty() && lines.back().starts_with(module))
          lines.back() += "; " + one.words;
        else
          lines.push_back(module + one.words);
      }
      break;
    case Change::anew: {
      std::string line = difference.device + " is restarted: ";
      for (const std::string& reason : difference.reasons)
        line += (&reason == difference.reasons.data() ? "" : "; ") + reason;
      lines.push_back(line);
      break;
    }
    case Change::added:
      lines.push_back(difference.device + " is new");
      break;
    case Change::removed:
      lines.push_back(difference.device + " is stopped: it is no longer in the cell");
      break;
  }
  return lines;
}

Result<std::vector<DeviceDifference>> differences(const Cell& before, const Cell& after) {
  if (Problems problems = check_cell_values(before, after); !problems.empty()) return problems;
  std::vector<DeviceDifference> all;
  for (const Device& device : after.devices) {
    const Device* const was = find_device(before, device.name);
    all.push_back(was != nullptr ? difference_of(before, *was, after, device)
                                 : DeviceDifference{.device = device.name, .change = Change::added});
  }
  for (const Device& device : before.devices) {
    if (find_device(after, device.name) == nullptr)
      all.push_back({.device = device.name, .change = Change::removed});
  }
  return all;
}

}  // namespace takt::model
