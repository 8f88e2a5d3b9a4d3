#include <takt/core/result.hpp>

#include <takt/core/words.hpp>

namespace takt {

namespace {

std::string joined(const Problem& problem, const char* kind) {
  std::string text = problem.where.empty() ? "" : problem.where + ": ";
  text += kind + problem.what;
  if (!problem.fix.empty()) text += "; " + problem.fix;
  return on_one_line(text);
}

}  // namespace

std::string to_text(const Problem& problem) { return joined(problem, "error: "); }

std::string in_words(const Problems& problems) {
  std::string text;
  for (const Problem& problem : problems) text += (text.empty() ? "" : ". ") + joined(problem, "");
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
