#include "expand.hpp"

#include <algorithm>
#include <set>

#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/validate.hpp>
#include "element.hpp"
#include "parameters.hpp"

namespace takt::descriptor {

namespace {

const Shape kUse{.attributes = {"template", "name"}, .many = {"set"}};
const Shape kSet{.attributes = {"name"}, .text = true};
const Shape kExport{.attributes = {"port", "of"}};

/// The character between the name of a use and the name of one of its modules. This is not '-', because some
/// DDS implementations do not allow '-' in topic names.
constexpr char kJoint = '_';

std::string joined(const std::string& prefix, const std::string& name) {
  return prefix.empty() ? name : prefix + kJoint + name;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  while (true) {
    const std::size_t dot = text.find('.', from);
    parts.push_back(text.substr(from, dot - from));
    if (dot == std::string::npos) return parts;
    from = dot + 1;
  }
}

std::string name_of(const Node& module) {
  if (const Node* name = module.child("name")) return trimmed(name->text());
  const Node* filename = module.child("filename");
  return filename == nullptr ? std::string{} : model::file_stem(trimmed(filename->text()));
}

void set_name(Node& module, const std::string& name, model::Line line) {
  if (Node* element = module.child("name")) {
    element->texts = {{name, element->line}};
    return;
  }
  module.children.insert(module.children.begin(),
                         Node{.name = "name", .line = line, .texts = {{name, line}}});
}

template <class Map>
std::vector<std::string_view> keys_of(const Map& map) {
  std::vector<std::string_view> keys;
  for (const auto& [key, value] : map) keys.emplace_back(key);
  return keys;
}

}  // namespace

void Expansion::expand(Node& root) {
  templates_.take_from(root);
  templates_missing_ = templates_missing_ || templates_.incomplete();
  check_references(root);
  if (root.name == "root") {
    expand_device(root, "", root);
    return;
  }
  if (root.name != "cell") return;
  for (Node& child : root.children) {
    if (child.name != "device") continue;
    const Attribute* name = child.attribute("name");
    expand_device(child, name == nullptr ? "" : trimmed(name->value), root);
  }
  for (Node& connection : connections_) root.children.push_back(std::move(connection));
  if (uses_.empty()) return;
  for (Node& child : root.children) {
    if (child.name == "connection") resolve(child);
  }
}

/// Reports each reference to a parameter that is outside a template. Call this after the templates were
/// removed from the tree.
void Expansion::check_references(Node& root) {
  substitute(
      root, [](std::string_view) -> const std::string* { return nullptr; },
      [this](model::Line line, std::optional<std::string_view> name) {
        report_.add(line,
                    name ? "unknown parameter " + in_quotes(*name) + ": only templates have parameters"
                         : "a ${ is not closed",
                    "write $${ for a literal ${");
      });
}

void Expansion::expand_device(Node& device, const std::string& name, Node& root) {
  const bool any = std::any_of(device.children.begin(), device.children.end(),
                               [](const Node& child) { return child.name == "use"; });
  if (!any) return;
  std::vector<Node> children = std::move(device.children);
  device.children.clear();
  const std::size_t connections = connections_.size();
  for (Node& child : children) {
    if (child.name == "use") {
      expand_use(child, {device, name, ""});
    } else {
      device.children.push_back(std::move(child));
    }
  }
  check_names(device, name);
  if (device.name != "root" || connections_.size() == connections) return;
  report_.add(connections_[connections].line, "a template with connections is used in a <root>",
              "use a <cell> with one <device> instead: a <root> has no connections");
  connections_.resize(connections);
  root.incomplete = true;
}

void Expansion::expand_use(const Node& use, Target target) {
  const auto give_up = [&] { target.parent.incomplete = true; };
  if (full_ || report_.full()) return give_up();
  const Element element{use, kUse, report_};
  const auto template_name = element.required_attribute("template");
  const auto given_name = element.required_attribute("name");
  if (!template_name || !given_name) return give_up();
  const std::string own = given_name->trimmed();
  const std::string name = joined(target.prefix, own);
  if (!model::is_valid_name(own) || !model::is_valid_name(name)) {
    report_.add(given_name->line,
                in_quotes(model::is_valid_name(own) ? name : own) + " is not a valid name for a <use>",
                model::kNameRule);
    return give_up();
  }
  const Template* used = templates_.find(template_name->trimmed());
  const auto [known, is_new] = uses_.try_emplace(
      {target.device, name}, Used{.template_name = template_name->trimmed(), .line = use.line});
  if (!is_new) {
    report_.add(
        use.line,
        "duplicate use " + in_quotes(name) +
            (target.device.empty() ? "" : " on device " + in_quotes(target.device)),
        "the first is " + report_.whereabouts(known->second.line) + "; give one of them another name");
    return give_up();
  }
  Used& record = known->second;
  Values values{{std::string{kOwnName}, name}};
  record.incomplete = true;
  if (used == nullptr) {
    const auto names = templates_.names();
    if (!templates_missing_) {
      report_.add(template_name->line, "unknown template " + in_quotes(template_name->trimmed()),
                  names.empty() ? "add a <template>, or <include> a file that has one"
                                : suggestion(template_name->trimmed(), names));
    }
    return give_up();
  }
  const bool right = read_values(use, *used, name, values);
  if (!right || element.has_unknown_children() || used->broken) return give_up();
  if (!fits(use, *used)) return give_up();

  record.incomplete = used->node.incomplete;
  record.is_module = used->alone;
  if (record.incomplete) give_up();
  const std::uint32_t held_in = used->node.line.insertion;
  insertions_.push_back({held_in == 0 ? file_ : insertions_[held_in - 1].file, use.line, true});
  make(*used, values, static_cast<std::uint32_t>(insertions_.size()), {target.parent, target.device, name},
       record);
}

/// Reads the parameter values of one use. Returns false if there was a mistake, which is reported.
bool Expansion::read_values(const Node& use, const Template& used, const std::string& name, Values& values) {
  std::map<std::string, model::Line, std::less<>> set;
  std::vector<std::string_view> names;
  for (const Parameter& parameter : used.parameters) names.emplace_back(parameter.name);
  bool right = true;
  for (const Node& child : use.children) {
    if (child.name != "set") continue;
    const Element element{child, kSet, report_};
    const auto given = element.required_attribute("name");
    const auto reject = [&](std::string what, std::string fix) {
      report_.add(given->line, std::move(what), std::move(fix));
      right = false;
    };
    if (!given || element.has_unknown_children()) {
      right = false;
      continue;
    }
    const std::string parameter = given->trimmed();
    const auto [first, is_new] = set.emplace(parameter, element.line());
    if (std::find(names.begin(), names.end(), parameter) == names.end()) {
      if (used.broken)
        // The template may have this parameter, because parts of the template could not be read.
        continue;
      reject("template " + in_quotes(used.name) + " has no parameter " + in_quotes(parameter),
             names.empty() ? "it has no parameters" : suggestion(parameter, names));
    } else if (!is_new) {
      reject("parameter " + in_quotes(parameter) + " is set twice",
             "the first <set> is " + report_.whereabouts(first->second));
    } else {
      values[parameter] = element.text();
    }
  }
  for (const Parameter& parameter : used.parameters) {
    if (values.count(parameter.name) > 0) continue;
    if (parameter.value) {
      values[parameter.name] = *parameter.value;
    } else if (set.count(parameter.name) == 0) {
      report_.add(use.line,
                  "use " + in_quotes(name) + " does not set parameter " + in_quotes(parameter.name) +
                      " of template " + in_quotes(used.name),
                  "add <set name=\"" + parameter.name + "\">...</set>, or give the parameter a default " +
                      report_.whereabouts(parameter.line));
      right = false;
    }
  }
  return right;
}

/// Checks the size of a use before anything is created, because a few templates, each of which uses the next
/// one twice, can expand to a huge size. Returns false, and reports the problem, if the descriptor becomes
/// too large.
bool Expansion::fits(const Node& use, const Template& used) {
  if (use.line.insertion != 0 && insertions_[use.line.insertion - 1].used)
    return true;  // the use is inside a template, and the size of the outer use includes it
  parts_ += used.size;
  if (parts_ <= kMaxParts) return true;
  full_ = true;
  const std::string number = used.size == kUncountable ? "more than 10^18" : std::to_string(used.size);
  report_.add(use.line,
              "the templates expand to too many parts: this use of template " + in_quotes(used.name) +
                  " alone makes " + number + " elements, attributes and texts",
              "a descriptor may have at most " + std::to_string(kMaxParts));
  return false;
}

/// Copies a node of a template and its descendants. In the copy, values replace the references to parameters,
/// and all lines belong to `insertion`.
Node Expansion::copy_of(const Node& node, std::uint32_t insertion, const Values& values) {
  const Meaning meaning = [&values](std::string_view name) -> const std::string* {
    const auto found = values.find(name);
    return found == values.end() ? nullptr : &found->second;
  };
  const auto value_of = [&](const std::string& text) -> std::string {
    if (full_) return {};
    std::string value = text.find("${") == std::string::npos ? text : substituted(text, meaning, [](auto) {});
    bytes_ += value.size();
    if (bytes_ > kMaxBytes) {
      full_ = true;
      report_.add({node.line.number, insertion},
                  "the templates expand to more than " + std::to_string(kMaxBytes >> 20U) + " MiB of values",
                  "use shorter or fewer values");
    }
    return value;
  };
  Node copy{.name = node.name, .line = {node.line.number, insertion}};
  for (const Attribute& one : node.attributes)
    copy.attributes.push_back({one.name, value_of(one.value), {one.line.number, insertion}});
  for (const Text& one : node.texts) copy.texts.push_back({value_of(one.text), {one.line.number, insertion}});
  for (const Node& child : node.children) copy.children.push_back(copy_of(child, insertion, values));
  return copy;
}

void Expansion::make(const Template& used, const Values& values, std::uint32_t insertion, Target target,
                     Used& record) {
  std::vector<Node> others;
  std::vector<std::string>& inner = inner_[{target.device, target.prefix}];
  for (const Node& child : used.node.children) {
    if (child.name == "parameter") continue;
    Node copy = copy_of(child, insertion, values);
    if (full_) {
      target.parent.incomplete = true;
      record.incomplete = true;
      return;
    }
    if (copy.name == "module") {
      if (used.alone) {
        set_name(copy, target.prefix, insertions_[insertion - 1].at);
      } else if (copy.child("name") != nullptr) {
        inner.push_back(name_of(copy));
        if (!model::is_valid_name(inner.back())) {
          report_.add(copy.child("name")->line, in_quotes(inner.back()) + " is not a valid module name",
                      model::kNameRule);
          target.parent.incomplete = true;
          continue;
        }
        set_name(copy, joined(target.prefix, inner.back()), copy.line);
      }
      target.parent.children.push_back(std::move(copy));
    } else if (copy.name == "use") {
      if (const Attribute* name = copy.attribute("name")) inner.push_back(trimmed(name->value));
      expand_use(copy, target);
    } else {
      others.push_back(std::move(copy));
    }
  }
  for (Node& other : others) {
    if (other.name == "export") {
      read_export(other, used, target, record);
    } else if (other.name == "connection") {
      make_absolute(other, used, target);
      connections_.push_back(std::move(other));
    }
  }
}

/// Returns true if the template contains a module or use with the name `inner`. Otherwise reports `given`,
/// the text that contains this name.
bool Expansion::check_inner(const std::string& inner, const Given& given, const Template& used,
                            const Target& target) {
  const std::vector<std::string>& names = inner_[{target.device, target.prefix}];
  if (std::find(names.begin(), names.end(), inner) != names.end()) return true;
  // If the name of a module could not be read, that name may be `inner`.
  if (used.node.incomplete || !std::all_of(names.begin(), names.end(), model::is_valid_name)) return false;
  const std::vector<std::string_view> choices{names.begin(), names.end()};
  report_.add(
      given.line,
      given.what + " names " + in_quotes(inner) + ", which is not a module or use of template " +
          in_quotes(used.name),
      choices.empty()
          ? "the only module of this template has the name of the use: connect to the ports of the use"
          : suggestion(inner, choices));
  return false;
}

void Expansion::read_export(const Node& node, const Template& used, const Target& target, Used& record) {
  const Element element{node, kExport, report_};
  const auto port = element.required_attribute("port");
  const auto of = element.required_attribute("of");
  record.incomplete = record.incomplete || !port || !of;
  if (!port || !of) return;
  const auto reject = [&](const Given& given, std::string what, std::string fix) {
    report_.add(given.line, std::move(what), std::move(fix));
    record.incomplete = true;
  };
  const std::string name = port->trimmed();
  if (!model::is_valid_name(name))
    return reject(*port, in_quotes(port->text) + " is not a valid port name", model::kNameRule);
  const std::vector<std::string> parts = split(of->trimmed());
  if (parts.size() != 2 || !model::is_valid_name(parts[0]) || !model::is_valid_name(parts[1]))
    return reject(*of, "attribute 'of' is not valid: " + in_quotes(of->trimmed()),
                  "write module.port, where the module is in this template");
  if (!check_inner(parts[0], *of, used, target)) {
    record.incomplete = true;
    return;
  }
  Port exported{joined(target.prefix, parts[0]), parts[1]};
  const auto inner = uses_.find({target.device, exported.module});
  if (inner != uses_.end() && !inner->second.is_module) {
    const auto found = inner->second.exports.find(parts[1]);
    if (found == inner->second.exports.end()) {
      record.incomplete = true;
      if (inner->second.incomplete) return;
      return reject(
          *of,
          "template " + in_quotes(inner->second.template_name) + " exports no port " + in_quotes(parts[1]),
          inner->second.exports.empty() ? "add an <export> to that template"
                                        : suggestion(parts[1], keys_of(inner->second.exports)));
    }
    exported = found->second;
  }
  if (!record.exports.emplace(name, std::move(exported)).second)
    reject(*port, "duplicate export " + in_quotes(name) + " of template " + in_quotes(used.name),
           "export it once");
}

/// Completes the ends of a connection in a template: "servo.out" becomes the full name of that port. An end
/// with three parts names a port outside the template and remains unchanged.
void Expansion::make_absolute(Node& connection, const Template& used, const Target& target) {
  for (const char* side : {"from", "to"}) {
    Attribute* end = connection.attribute(side);
    if (end == nullptr) continue;
    const std::vector<std::string> parts = split(trimmed(end->value));
    if (parts.size() == 3) continue;
    const Given given{"attribute " + in_quotes(side), end->value, end->line, false};
    if (parts.size() != 2 || !model::is_valid_name(parts[0]) || !model::is_valid_name(parts[1])) {
      report_.add(end->line, given.what + " is not valid: " + in_quotes(trimmed(end->value)),
                  "in a template, write module.port, or device.module.port for a port outside the template");
      connection.incomplete = true;
      continue;
    }
    if (!check_inner(parts[0], given, used, target)) connection.incomplete = true;
    end->value = target.device + "." + joined(target.prefix, parts[0]) + "." + parts[1];
  }
  if (!model::is_valid_name(target.device))
    connection.incomplete = true;  // the name of the device is not valid, which was reported
}

/// If an end of the connection names a port that a use exports, replaces this end by the module's port that
/// is exported.
void Expansion::resolve(Node& connection) {
  for (const char* side : {"from", "to"}) {
    Attribute* end = connection.attribute(side);
    if (end == nullptr) continue;
    const std::vector<std::string> parts = split(trimmed(end->value));
    if (parts.size() != 3) continue;
    const auto found = uses_.find({parts[0], parts[1]});
    if (found == uses_.end() || found->second.is_module) continue;
    const Used& used = found->second;
    const auto port = used.exports.find(parts[2]);
    if (port != used.exports.end()) {
      end->value = parts[0] + "." + port->second.module + "." + port->second.port;
      continue;
    }
    connection.incomplete = true;
    if (used.incomplete) continue;
    report_.add(end->line,
                "attribute " + in_quotes(side) + " names port " + in_quotes(parts[2]) + " of " +
                    in_quotes(parts[0] + "." + parts[1]) + ", which template " +
                    in_quotes(used.template_name) + " does not export",
                used.exports.empty() ? "add an <export> to the template"
                                     : suggestion(parts[2], keys_of(used.exports)));
  }
}

/// Reports each module that has the same name as a use on its device, because connections to that name would
/// be ambiguous.
void Expansion::check_names(const Node& device, const std::string& name) {
  for (const Node& child : device.children) {
    if (child.name != "module") continue;
    const auto used = uses_.find({name, name_of(child)});
    if (used == uses_.end() || used->second.is_module) continue;
    report_.add(child.line,
                "module " + in_quotes(used->first.second) + " has the same name as a use of a template",
                "the use is " + report_.whereabouts(used->second.line) + "; give one of them another name");
  }
}

}  // namespace takt::descriptor
