#include <takt/core/result.hpp>

namespace takt {

std::string to_text(const Problem& problem) {
  std::string text = problem.where.empty() ? "" : problem.where + ": ";
  text += "error: " + problem.what;
  if (!problem.fix.empty()) text += "; " + problem.fix;
  return text;
}

std::string to_text(const Problems& problems) {
  std::string text;
  for (const Problem& problem : problems) {
    if (!text.empty()) text += '\n';
    text += to_text(problem);
  }
  return text;
}

}  // namespace takt
