// Inserts the files that a descriptor includes into its tree.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

inline constexpr std::size_t kMaxIncludeDepth = 8;  ///< levels of includes within included files
inline constexpr std::size_t kMaxIncludes = 1000;   ///< the number of includes in one descriptor

/// Returns the content of an included file. On the command line, the function reads the file system. In a
/// node it looks in the bundle only, because a node must not open files that a text from the network names.
using ReadFile = std::function<Result<std::string>(const std::string& path)>;

/// Replaces every <include> of a tree by the content of the <fragment> in the file that it names. On failure,
/// reports the problem and marks the parent as incomplete.
class Includes {
 public:
  Includes(std::vector<model::Insertion>& insertions, ReadFile read, Report& report)
      : insertions_(insertions), read_(std::move(read)), report_(report) {}

  /// `file` is the path of the descriptor, `bytes` its size.
  void put_into(Node& root, const std::string& file, std::size_t bytes);

  /// The texts of all included files, by path.
  [[nodiscard]] const std::map<std::string, std::string>& texts() const { return texts_; }
  /// Whether an include could not be inserted.
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

/// The path of a `file` that is relative to the file `from`, without redundant . and ..
std::string path_beside(const std::string& from, const std::string& file);

}  // namespace takt::descriptor
