// Replaces each use of a template by the content of the template.
//
// In the descriptor of a cell with six equal axes, the author writes one template for the axis. The expanded
// tree contains only modules and connections, as if the author had written each of them by hand. So no other
// part of Takt has code for templates. A problem cites both the line in the template and the line of the use.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "element.hpp"
#include "report.hpp"
#include "template.hpp"
#include "tree.hpp"

namespace takt::descriptor {

class Expansion {
 public:
  /// `file` is the path of the descriptor. `templates_missing` is true if an include could not be read; then
  /// Expansion does not report unknown templates.
  Expansion(std::string file, std::vector<model::Insertion>& insertions, bool templates_missing,
            Report& report)
      : file_(std::move(file)),
        insertions_(insertions),
        templates_missing_(templates_missing),
        report_(report),
        templates_(report) {}

  /// Replaces each <use> by the modules and connections of its template. If an end of a connection names a
  /// port that a use exports, replaces this end by the exported port. If a <use> cannot be expanded, reports
  /// the problem and marks the parent as incomplete.
  void expand(Node& root);

 private:
  using Values = std::map<std::string, std::string, std::less<>>;
  /// A port of a module inside a use, with the names that the module and the port have on the device. For
  /// example, "servo.setpoint" in the template of use "axis1" becomes module "axis1_servo" and port
  /// "setpoint".
  struct Port {
    std::string module;
    std::string port;
  };
  /// The data of a use that are needed to resolve connections to its ports and to check names.
  struct Used {
    std::string template_name;
    model::Line line;
    std::map<std::string, Port, std::less<>> exports{};
    bool is_module = false;   ///< true if the use has a single module, which has the name of the use
    bool incomplete = false;  ///< true if the use may have further exports that could not be read
  };
  /// The place where the modules of a use are inserted.
  struct Target {
    Node& parent;        ///< the element to which the modules are added
    std::string device;  ///< the name of the device
    std::string prefix;  ///< prefix of all module names; empty for modules directly on the device
  };

  void check_references(Node& root);
  void expand_device(Node& device, const std::string& name, Node& root);
  void expand_use(const Node& use, Target target);
  bool read_values(const Node& use, const Template& used, const std::string& name, Values& values);
  bool fits(const Node& use, const Template& used);
  Node copy_of(const Node& node, std::uint32_t insertion, const Values& values);
  void make(const Template& used, const Values& values, std::uint32_t insertion, Target target, Used& record);
  void read_export(const Node& node, const Template& used, const Target& target, Used& record);
  void make_absolute(Node& connection, const Template& used, const Target& target);
  bool check_inner(const std::string& inner, const Given& given, const Template& used, const Target& target);
  void resolve(Node& connection);
  void check_names(const Node& device, const std::string& name);

  std::string file_;
  std::vector<model::Insertion>& insertions_;
  bool templates_missing_;
  Report& report_;
  Templates templates_;
  std::map<std::pair<std::string, std::string>, Used> uses_;  // by name of the device and name of the use
  // The names of the modules and uses inside each use, by name of the device and name of the use.
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> inner_;
  std::vector<Node> connections_;
  std::size_t parts_ = 0;
  std::size_t bytes_ = 0;
  bool full_ = false;
};

}  // namespace takt::descriptor
