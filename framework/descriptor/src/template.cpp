#include "template.hpp"

#include <algorithm>

#include <takt/core/words.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/validate.hpp>
#include "element.hpp"
#include "parameters.hpp"
#include "read_module.hpp"

namespace takt::descriptor {

namespace {

const Shape kTemplate{.attributes = {"name"}, .many = {"parameter", "module", "use", "connection", "export"}};
const Shape kParameter{.attributes = {"name", "default"}};

// Maximum number of templates in the message about a template that uses itself.
constexpr std::size_t kMostNamed = 5;

std::size_t parts_of(const Node& node) {
  std::size_t parts = 1 + node.attributes.size() + node.texts.size();
  for (const Node& child : node.children) parts += parts_of(child);
  return parts;
}

std::size_t sum(std::size_t a, std::size_t b) { return std::min(a + b, kUncountable); }

}  // namespace

void Templates::take_from(Node& root) {
  take_out(root);
  for (auto& [name, one] : all_) read(one);
  count();
}

void Templates::take_out(Node& parent) {
  std::vector<Node> kept;
  for (Node& child : parent.children) {
    if (child.name != "template") {
      if (child.name == "device") take_out(child);
      kept.push_back(std::move(child));
      continue;
    }
    const Element element{child, kTemplate, report_};
    const auto name = element.required_attribute("name");
    if (!name || !model::is_valid_name(name->trimmed())) {
      incomplete_ = true;
      if (name)
        report_.add(name->line, in_quotes(name->text) + " is not a valid template name", model::kNameRule);
      continue;
    }
    child.incomplete = element.has_unknown_children();
    const auto line = child.line;
    const auto [known, is_new] =
        all_.try_emplace(name->trimmed(), Template{name->trimmed(), std::move(child)});
    // If the descriptor includes a file twice, the templates of the file occur twice. Such a template is not
    // a duplicate.
    const auto first = known->second.node.line;
    const bool again = first.insertion != line.insertion && report_.location(first) == report_.location(line);
    if (is_new || again) continue;
    report_.add(
        line, "duplicate template " + in_quotes(known->first),
        "the first is " + report_.whereabouts(known->second.node.line) + "; give one of them another name");
  }
  parent.children = std::move(kept);
}

void Templates::read(Template& one) {
  const Node& node = one.node;
  std::vector<const Node*> parameters;
  std::size_t members = 0;
  for (const Node& child : node.children) {
    if (child.name == "parameter") parameters.push_back(&child);
    if (child.name == "module" || child.name == "use") ++members;
    if (child.name != "use") continue;
    const Attribute* used = child.attribute("template");
    if (used == nullptr) continue;  // the expansion of this use reports the missing attribute
    if (used->value.find("${") != std::string::npos) {
      report_.add(used->line, "the template of a <use> is given by a parameter",
                  "write the name of the template");
      one.broken = true;
    } else {
      one.uses.push_back(trimmed(used->value));
    }
  }
  if (members == 0 && !node.incomplete) {
    report_.add(node.line, "template " + in_quotes(one.name) + " is empty",
                "give it at least one <module> or <use>");
    one.broken = true;
  }
  for (const Node& child : node.children) {
    if (child.name != "module" || child.child("name") != nullptr) continue;
    one.alone = members == 1;
    if (one.alone) continue;
    // The module may have a misspelled <name>, that is, an unknown element. The expansion of the use reports
    // this element.
    if (std::any_of(child.children.begin(), child.children.end(),
                    [](const Node& c) { return !is_of_module(c.name); })) {
      one.node.incomplete = true;
      continue;
    }
    report_.add(child.line,
                "a module in template " + in_quotes(one.name) +
                    " has no <name>, but the template contains more than this module",
                "add a <name>; only a module that is alone in its template gets the name of the use");
    one.broken = true;
  }
  read_parameters(one, parameters);
  check_references(one);
  one.size = 1;
  for (const Node& child : node.children) one.size += child.name == "parameter" ? 0 : parts_of(child);
}

void Templates::read_parameters(Template& one, const std::vector<const Node*>& nodes) {
  for (const Node* node : nodes) {
    const Element element{*node, kParameter, report_};
    const auto name = element.required_attribute("name");
    if (!name) {
      one.broken = true;
      continue;
    }
    Parameter parameter{name->trimmed(), std::nullopt, element.line()};
    if (const auto given = element.attribute("default")) parameter.value = given->text;
    const auto first = std::find_if(one.parameters.begin(), one.parameters.end(),
                                    [&](const Parameter& other) { return other.name == parameter.name; });
    const auto reject = [&](std::string what, std::string fix) {
      report_.add(name->line, std::move(what), std::move(fix));
      one.broken = true;
    };
    if (!model::is_valid_name(parameter.name)) {
      reject(in_quotes(name->text) + " is not a valid parameter name", model::kNameRule);
    } else if (parameter.name == kOwnName) {
      reject("a parameter has the reserved name 'name'",
             "choose another name: ${name} is the name of the use");
    } else if (first != one.parameters.end()) {
      reject("duplicate parameter " + in_quotes(parameter.name),
             "the first is " + report_.whereabouts(first->line) + "; give one of them another name");
    } else {
      one.parameters.push_back(std::move(parameter));
    }
  }
}

/// Checks that each reference in a template names a parameter, and that each parameter is referenced.
void Templates::check_references(Template& one) {
  std::set<std::string_view> used;
  std::vector<std::string_view> names{kOwnName};
  for (const Parameter& parameter : one.parameters) names.push_back(parameter.name);
  static const std::string kAnything;
  const Meaning meaning = [&](std::string_view name) -> const std::string* {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return nullptr;
    used.insert(*found);
    return &kAnything;
  };
  const bool all_known = !one.broken;
  for (const Node& child : one.node.children) {
    if (child.name == "parameter") {
      const Attribute* value = child.attribute("default");
      if (value == nullptr || value->value.find("${") == std::string::npos) continue;
      report_.add(value->line, "the default of a parameter refers to another parameter",
                  "write the value itself");
      one.broken = true;
      continue;
    }
    Node copy = child;
    substitute(copy, meaning, [&](model::Line line, std::optional<std::string_view> name) {
      one.broken = true;
      if (!name) {
        report_.add(line, "a ${ is not closed", "write ${NAME} for a parameter, or $${ for a literal ${");
      } else if (all_known) {
        report_.add(line, "unknown parameter " + in_quotes(*name) + " of template " + in_quotes(one.name),
                    nearest(*name, names).empty() ? "add a <parameter name=\"" + std::string{*name} + "\">"
                                                  : suggestion(*name, names));
      }
    });
  }
  if (one.broken || one.node.incomplete) return;
  for (const Parameter& parameter : one.parameters) {
    if (used.count(parameter.name) > 0) continue;
    report_.add(
        parameter.line,
        "parameter " + in_quotes(parameter.name) + " of template " + in_quotes(one.name) + " is not used",
        "remove it, or write ${" + parameter.name + "} where its value belongs");
  }
}

/// Computes the size and depth of each template. Begins with the templates that use no other templates, and
/// continues with the templates that use only these, and so on. A template that this computation never
/// reaches uses itself, directly or through other templates.
void Templates::count() {
  std::map<std::string_view, std::vector<Template*>> users;
  std::map<std::string_view, std::size_t> open;
  std::vector<Template*> ready;
  std::set<std::string_view> left;
  for (auto& [name, one] : all_) {
    left.insert(name);
    for (const std::string& used : one.uses) {
      if (find(used) == nullptr) continue;
      users[used].push_back(&one);
      ++open[name];
    }
    one.depth = 1;
    if (open[name] == 0) ready.push_back(&one);
  }
  while (!ready.empty()) {
    const Template& done = *ready.back();
    ready.pop_back();
    left.erase(done.name);
    for (Template* user : users[done.name]) {
      user->size = sum(user->size, done.size);
      user->depth = std::max(user->depth, done.depth + 1);
      if (--open[user->name] == 0) ready.push_back(user);
    }
  }
  for (auto& [name, one] : all_) {
    if (left.count(name) > 0) one.broken = true;
    if (one.depth != kMaxUseDepth + 1 || one.broken)
      // Reports only the innermost template that is nested too deeply, not the templates that use it.
      continue;
    report_.add(one.node.line,
                "template " + in_quotes(name) + " nests templates more than " + std::to_string(kMaxUseDepth) +
                    " levels deep",
                "reduce the nesting");
  }
  for (auto& [name, one] : all_) one.broken = one.broken || one.depth > kMaxUseDepth;
  report_circles(left);
}

void Templates::report_circles(const std::set<std::string_view>& in_circles) {
  // For each visited template, the number of the walk that visited the template.
  std::map<std::string_view, std::size_t> walked;
  std::size_t walk = 0;
  for (const std::string_view start : in_circles) {
    ++walk;
    std::vector<const Template*> path;
    const Template* at = find(start);
    while (at != nullptr && walked.count(at->name) == 0) {
      walked[at->name] = walk;
      path.push_back(at);
      const auto next = std::find_if(at->uses.begin(), at->uses.end(),
                                     [&](const std::string& used) { return in_circles.count(used) > 0; });
      at = next == at->uses.end() ? nullptr : find(*next);
    }
    if (at == nullptr || walked[at->name] != walk) continue;
    std::string circle;
    std::size_t named = 0;
    for (auto each = std::find(path.begin(), path.end(), at); each != path.end() && named < kMostNamed;
         ++each, ++named)
      circle += brief((*each)->name) + " (" + brief(report_.location((*each)->node.line)) + ") uses ";
    if (named == kMostNamed) circle += "other templates, which use ";
    report_.add(at->node.line, "template " + in_quotes(at->name) + " uses itself: " + circle + "it again",
                "remove one of these uses");
  }
}

const Template* Templates::find(std::string_view name) const {
  const auto found = all_.find(name);
  return found == all_.end() ? nullptr : &found->second;
}

std::vector<std::string_view> Templates::names() const {
  std::vector<std::string_view> names;
  for (const auto& [name, one] : all_) names.push_back(name);
  return names;
}

}  // namespace takt::descriptor
