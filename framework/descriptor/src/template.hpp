// The templates of a descriptor, before their uses are expanded.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

inline constexpr std::size_t kMaxUseDepth = 8;  ///< maximum number of levels of templates that use templates

struct Parameter {
  std::string name;
  std::optional<std::string> value;  ///< the default value; if there is none, each use must set the parameter
  model::Line line{};
};

struct Template {
  std::string name;
  Node node;
  std::vector<Parameter> parameters{};
  std::vector<std::string> uses{};  ///< names of the templates that this template uses
  /// Number of elements, attributes and texts that one use creates, at most kUncountable.
  std::size_t size = 0;
  std::size_t depth = 0;  ///< number of levels of nested templates; 1 if the template uses none
  bool broken = false;  ///< true if the template has a mistake, which was reported; its uses are not expanded
  bool alone = false;   ///< true if the template has a single module, which gets the name of the use
};

inline constexpr std::size_t kUncountable = 1'000'000'000'000'000'000;

/// Removes the templates from a tree, and checks each template: its parameters, the references to these
/// parameters, the templates that it uses, and the size of one use.
class Templates {
 public:
  explicit Templates(Report& report) : report_(report) {}

  void take_from(Node& root);

  /// Returns the template with this name; null if there is none.
  [[nodiscard]] const Template* find(std::string_view name) const;
  [[nodiscard]] std::vector<std::string_view> names() const;
  /// Returns true if a template could not be read. Then a template may exist although find() returns null.
  [[nodiscard]] bool incomplete() const { return incomplete_; }

 private:
  void take_out(Node& parent);
  void read(Template& one);
  void read_parameters(Template& one, const std::vector<const Node*>& nodes);
  void check_references(Template& one);
  void count();
  void report_circles(const std::set<std::string_view>& in_circles);

  Report& report_;
  std::map<std::string, Template, std::less<>> all_;
  bool incomplete_ = false;
};

/// The predefined parameter of every template. Its value is the name of the use.
inline constexpr std::string_view kOwnName = "name";

}  // namespace takt::descriptor
