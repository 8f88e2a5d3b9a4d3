// The templates of a descriptor, as they are before anybody uses them.
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

inline constexpr std::size_t kMaxUseDepth = 8;  ///< templates in templates

struct Parameter {
  std::string name;
  std::optional<std::string> value;  ///< unless a use sets it; none: it must
  model::Line line{};
};

struct Template {
  std::string name;
  Node node;
  std::vector<Parameter> parameters{};
  std::vector<std::string> uses{};  ///< the templates that it uses
  std::size_t size = 0;             ///< elements and attributes that one use makes, at most kUncountable
  std::size_t depth = 0;            ///< 1: it uses none
  bool broken = false;              ///< was reported: no use of it makes anything
  bool alone = false;               ///< it holds one module, which is called as the use
};

inline constexpr std::size_t kUncountable = 1'000'000'000'000'000'000;

/// Takes the templates out of a tree and looks at each: its parameters, what refers to them, which templates
/// it uses, and how much one use would make, before anything is made.
class Templates {
 public:
  explicit Templates(Report& report) : report_(report) {}

  void take_from(Node& root);

  /// Null where there is none of that name.
  [[nodiscard]] const Template* find(std::string_view name) const;
  [[nodiscard]] std::vector<std::string_view> names() const;
  /// One could not be read: it may be the one that is not found.
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

/// The name of the use itself is known in each template.
inline constexpr std::string_view kOwnName = "name";

}  // namespace takt::descriptor
