// Reads the files that a descriptor includes, and inserts their content into the tree of the descriptor.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

inline constexpr std::size_t kMaxIncludeDepth = 8;  ///< maximum depth of includes within included files
inline constexpr std::size_t kMaxIncludes = 1000;   ///< maximum number of includes in one descriptor

/// Returns the content of an included file. The command line passes a function that reads from the file
/// system. A node passes a function that looks only in the bundle, because a node must not open files that
/// are named in a text from the network.
using ReadFile = std::function<Result<std::string>(const std::string& path)>;

/// Replaces every <include> in a tree by the content of the file that the <include> names. This file must
/// have the root element <fragment>. On failure, reports the problem and marks the parent of the <include> as
/// incomplete.
class Includes {
 public:
  Includes(std::vector<model::Insertion>& insertions, ReadFile read, Report& report)
      : insertions_(insertions), read_(std::move(read)), report_(report) {}

  /// Replaces all includes in the tree. `file` is the path of the descriptor, `bytes` is its size.
  void put_into(Node& root, const std::string& file, std::size_t bytes);

  /// Returns the texts of all included files, by path.
  [[nodiscard]] const std::map<std::string, std::string>& texts() const { return texts_; }
  /// Returns true if an include could not be replaced.
  [[nodiscard]] bool incomplete() const { return incomplete_; }

 private:
  void put_into(Node& parent, std::vector<std::string>& chain);
  bool put_in(const Node& include, Node& parent, std::vector<std::string>& chain);
  const std::string* text_of(const Node& include, const std::string& path);

  std::vector<model::Insertion>& insertions_;
  ReadFile read_;
  Report& report_;
  std::map<std::string, std::string> texts_;
  std::size_t bytes_ = 0;
  std::size_t includes_ = 0;
  bool incomplete_ = false;
};

/// Returns the path of `file`, if `file` is relative to the folder of the file `from`. Removes redundant
/// parts `.` and `..`.
std::string path_beside(const std::string& from, const std::string& file);

}  // namespace takt::descriptor
