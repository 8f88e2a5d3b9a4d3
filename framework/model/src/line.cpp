#include <takt/model/line.hpp>

#include <utility>

#include <takt/core/words.hpp>

namespace takt::model {

namespace {

/// The maximum number of uses and includes that one message lists, innermost first.
constexpr int kMostSteps = 8;

const Insertion* insertion_of(const Texts& texts, Line line) {
  if (line.insertion == 0 || line.insertion > texts.insertions.size()) return nullptr;
  return &texts.insertions[line.insertion - 1];
}

}  // namespace

std::string location(const Texts& texts, Line line) {
  const Insertion* insertion = insertion_of(texts, line);
  return takt::location(insertion == nullptr ? texts.file : insertion->file, line.number);
}

std::string history(const Texts& texts, Line line) {
  std::string text;
  int steps = 0;
  for (const Insertion* step = insertion_of(texts, line); step != nullptr && steps < kMostSteps; ++steps) {
    // An insertion refers only to earlier insertions, so the loop ends. If the data violate this, `before` is
    // null.
    const Insertion* before = step->at.insertion < line.insertion ? insertion_of(texts, step->at) : nullptr;
    text += (text.empty() ? "" : ", ") + std::string{step->used ? "used at " : "included at "} +
            location(texts, step->at);
    line = step->at;
    step = before;
  }
  return text;
}

std::string whereabouts(const Texts& texts, Line line) {
  if (line.insertion == 0) return "on line " + std::to_string(line.number);
  return "at " + location(texts, line) + " (" + history(texts, line) + ")";
}

Problem problem_at(const Texts& texts, Line line, std::string what, std::string fix) {
  const std::string how = history(texts, line);
  if (!how.empty()) what += " (" + how + ")";
  return {location(texts, line), std::move(what), std::move(fix)};
}

}  // namespace takt::model
