#include <takt/model/line.hpp>

#include <utility>

#include <takt/core/words.hpp>

namespace takt::model {

namespace {

/// The maximum number of uses and includes that one message lists. It lists the innermost ones.
constexpr int kMostSteps = 8;

const Insertion* insertion_of(const Texts& texts, Line line) {
  if (line.insertion == 0 || line.insertion > texts.insertions.size()) return nullptr;
  return &texts.insertions[line.insertion - 1];
}

}  // namespace

std::string place(const Texts& texts, Line line) {
  const Insertion* insertion = insertion_of(texts, line);
  return takt::place(insertion == nullptr ? texts.file : insertion->file, line.number);
}

std::string history(const Texts& texts, Line line) {
  std::string text;
  int steps = 0;
  for (const Insertion* step = insertion_of(texts, line); step != nullptr && steps < kMostSteps; ++steps) {
    // The loop ends, because an insertion refers only to earlier insertions.
    const Insertion* before = step->at.insertion < line.insertion ? insertion_of(texts, step->at) : nullptr;
    text += (text.empty() ? "" : ", ") + std::string{step->used ? "used at " : "included at "} +
            place(texts, step->at);
    line = step->at;
    step = before;
  }
  return text;
}

std::string whereabouts(const Texts& texts, Line line) {
  if (line.insertion == 0) return "on line " + std::to_string(line.number);
  return "at " + place(texts, line) + " (" + history(texts, line) + ")";
}

Problem problem_at(const Texts& texts, Line line, std::string what, std::string fix) {
  const std::string how = history(texts, line);
  if (!how.empty()) what += " (" + how + ")";
  return {place(texts, line), std::move(what), std::move(fix)};
}

}  // namespace takt::model
