// Arbitrary bytes as a descriptor: either a cell that is right in every rule of the model, or problems that a
// person can read. What the scanner lets through, tinyxml2 reads.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <takt/core/check.hpp>
#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/validate.hpp>

namespace {

constexpr std::string_view kFile = "fuzz.xml:";

bool is_plain(const std::string& text) { return !text.empty() && takt::on_one_line(text) == text; }

void check_problem(const takt::Problem& problem, int last_line) {
  TAKT_CHECK(is_plain(problem.what));
  TAKT_CHECK(is_plain(problem.fix));
  TAKT_CHECK(problem.what.size() < 1000 && problem.fix.size() < 4000);
  TAKT_CHECK(problem.where.starts_with(kFile));
  const int line = std::stoi(problem.where.substr(kFile.size()));
  TAKT_CHECK(line >= 1 && line <= last_line);
  // Ours is the scanner that says what is not XML; tinyxml2 agrees with it.
  TAKT_CHECK(!problem.what.starts_with("the XML cannot be read"));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view xml{reinterpret_cast<const char*>(data), size};
  int last_line = 1;
  for (const char c : xml) last_line += c == '\n' ? 1 : 0;

  const auto cell = takt::descriptor::parse(xml, "fuzz.xml");
  if (cell) {
    TAKT_CHECK(takt::model::validate(*cell).empty());
    return 0;
  }
  TAKT_CHECK(!cell.problems().empty() && cell.problems().size() <= takt::model::kMaxProblems);
  for (const takt::Problem& problem : cell.problems()) check_problem(problem, last_line);
  return 0;
}
