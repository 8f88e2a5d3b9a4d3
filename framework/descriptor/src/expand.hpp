// Puts what templates hold where they are used.
//
// A cell of six equal axes has one axis written down. Behind this room nobody knows: the tree that comes out
// has modules and connections only, as if somebody had written each of them, and what does not fit is told
// with the line of the template and that of the use.
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
  /// `file` is the descriptor's. `templates_missing`: some could not be read, so that one which is not there
  /// is no mistake.
  Expansion(std::string file, std::vector<model::Insertion>& insertions, bool templates_missing,
            Report& report)
      : file_(std::move(file)),
        insertions_(insertions),
        templates_missing_(templates_missing),
        report_(report),
        templates_(report) {}

  /// Replaces each <use> by the modules and connections that it makes, and each end of a connection that
  /// names what a use exports by the port that it is. What cannot be made is reported, and its parent is
  /// incomplete.
  void expand(Node& root);

 private:
  using Values = std::map<std::string, std::string, std::less<>>;
  /// "servo.setpoint" in a template, "axis1_servo" and "setpoint" on the device.
  struct Port {
    std::string module;
    std::string port;
  };
  /// A use, as connections see it.
  struct Used {
    std::string template_name;
    model::Line line;
    std::map<std::string, Port, std::less<>> exports{};
    bool is_module = false;   ///< its one module is called as it is
    bool incomplete = false;  ///< it may export more
  };
  struct Place {
    Node& parent;        ///< that gets the modules
    std::string device;  ///< its name
    std::string prefix;  ///< what names begin with; empty on the device itself
  };

  void check_references(Node& root);
  void expand_device(Node& device, const std::string& name, Node& root);
  void expand_use(const Node& use, Place place);
  bool read_values(const Node& use, const Template& used, const std::string& name, Values& values);
  bool fits(const Node& use, const Template& used);
  Node copy_of(const Node& node, std::uint32_t insertion, const Values& values);
  void make(const Template& used, const Values& values, std::uint32_t insertion, Place place, Used& record);
  void read_export(const Node& node, const Template& used, const Place& place, Used& record);
  void make_absolute(Node& connection, const Template& used, const Place& place);
  bool check_inner(const std::string& inner, const Given& given, const Template& used, const Place& place);
  void resolve(Node& connection);
  void check_names(const Node& device, const std::string& name);

  std::string file_;
  std::vector<model::Insertion>& insertions_;
  bool templates_missing_;
  Report& report_;
  Templates templates_;
  std::map<std::pair<std::string, std::string>, Used> uses_;                       // by device and name
  std::map<std::pair<std::string, std::string>, std::vector<std::string>> inner_;  // names in a use
  std::vector<Node> connections_;
  std::size_t parts_ = 0;
  std::size_t bytes_ = 0;
  bool full_ = false;
};

}  // namespace takt::descriptor
