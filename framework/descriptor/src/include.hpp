// Puts the files that a descriptor includes into its tree.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

inline constexpr std::size_t kMaxIncludeDepth = 8;  ///< files in files
inline constexpr std::size_t kMaxIncludes = 1000;   ///< of one descriptor, all together

/// A file's content, at most a given number of bytes more than a descriptor may have. Of the command line the
/// file system; of a node, which must open nothing that a text from the network names, what came along with
/// that text.
using ReadFile = std::function<Result<std::string>(const std::string& path)>;

/// Every <include> of the tree is replaced by what stands in the <fragment> that it names. What cannot be put
/// in is reported, and its parent is incomplete.
class Includes {
 public:
  Includes(std::vector<model::Insertion>& insertions, ReadFile read, Report& report)
      : insertions_(insertions), read_(std::move(read)), report_(report) {}

  /// `file` is the path of the descriptor, which has `bytes`.
  void put_into(Node& root, const std::string& file, std::size_t bytes);

  /// What was read, by path.
  [[nodiscard]] const std::map<std::string, std::string>& texts() const { return texts_; }
  /// Something is not there.
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

/// The path of a file that `from` names, without . and .. where they say nothing.
std::string path_beside(const std::string& from, const std::string& file);

}  // namespace takt::descriptor
