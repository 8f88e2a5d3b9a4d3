// Gathers the problems of one file.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::descriptor {

class Report {
 public:
  explicit Report(std::string file) : file_(std::move(file)) {}

  /// Both texts in the words of core/words.hpp, so that nothing of the file breaks the line. Ignored when
  /// full.
  void add(int line, std::string what, std::string fix);
  /// What model::validate found.
  void add(Problems problems);

  /// No more problems are told; a reader need not look for them.
  [[nodiscard]] bool full() const;
  [[nodiscard]] bool empty() const { return problems_.empty(); }

  /// By line; problems of one line as they were added. Leaves the report empty.
  Problems take();

 private:
  std::string file_;
  std::vector<std::pair<int, Problem>> problems_;
};

}  // namespace takt::descriptor
