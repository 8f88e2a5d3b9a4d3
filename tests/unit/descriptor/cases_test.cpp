// Checks each descriptor in cases/ with the parser and with xmllint, so that the parser and the schema cannot
// drift apart. Comments in the descriptor state the problems that the parser must report, and whether the
// schema accepts the descriptor.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <folders.hpp>
#include <takt/descriptor/descriptor.hpp>

namespace takt::descriptor::cases_test {
namespace {

namespace fs = std::filesystem;

const std::string kCases = source_path("tests/unit/descriptor/cases/");
const std::string kSchema = source_path("config/takt.xsd");

std::vector<std::string> files_of(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator{folder}) {
    if (entry.path().extension() == ".xml") files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string content_of(const std::string& file) {
  std::ostringstream content;
  content << std::ifstream{file, std::ios::binary}.rdbuf();
  return content.str();
}

/// Finds all XML comments that begin with `beginning`. Returns the text that follows `beginning` in each of
/// them.
std::vector<std::string> notes(const std::string& content, const std::string& beginning) {
  std::vector<std::string> found;
  const std::string open = "<!-- " + beginning;
  for (std::size_t at = content.find(open); at != std::string::npos; at = content.find(open, at + 1)) {
    const std::size_t from = at + open.size();
    found.push_back(content.substr(from, content.find(" -->", from) - from));
  }
  return found;
}

TEST(DescriptorParser, AcceptsEveryValidExample) {
  const auto files = files_of(kCases + "good");
  EXPECT_GE(files.size(), 20U);
  for (const std::string& file : files) {
    const auto cell = load(file);
    EXPECT_TRUE(cell) << to_text(cell.problems());
  }
}

TEST(DescriptorParser, RejectsEveryInvalidExampleWithTheExpectedProblems) {
  const auto files = files_of(kCases + "bad");
  EXPECT_GE(files.size(), 60U);
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    const auto cell = load(file);
    ASSERT_FALSE(cell);
    const auto expected = notes(content_of(file), "line ");
    ASSERT_FALSE(expected.empty()) << "the file has no comment with the expected problem";
    EXPECT_EQ(cell.problems().size(), expected.size()) << to_text(cell.problems());
    for (const std::string& note : expected) {
      const std::string line = note.substr(0, note.find(':'));
      const std::string words = note.substr(note.find(':') + 2);
      const bool found =
          std::any_of(cell.problems().begin(), cell.problems().end(), [&](const Problem& problem) {
            return problem.where == file + ":" + line &&
                   (problem.what + "; " + problem.fix).find(words) != std::string::npos;
          });
      EXPECT_TRUE(found) << "expected on line " << line << ": " << words << "\n" << to_text(cell.problems());
    }
    for (const Problem& problem : cell.problems()) EXPECT_FALSE(problem.fix.empty()) << problem.what;
  }
}

/// Runs xmllint once on all files. Returns the files that the schema accepts.
std::set<std::string> accepted_by_schema(const std::vector<std::string>& files) {
  std::string command = "xmllint --nonet --noout --schema '" + kSchema + "'";
  for (const std::string& file : files) command += " '" + file + "'";
  std::set<std::string> accepted;
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
    const std::string line = buffer.data();
    constexpr std::string_view kYes = " validates\n";
    if (line.ends_with(kYes)) accepted.insert(line.substr(0, line.size() - kYes.size()));
  }
  ::pclose(pipe);
  return accepted;
}

TEST(DescriptorSchema, AgreesWithTheParserWhereverXsdCanExpressTheRule) {
  if (std::system("xmllint --version >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "xmllint (libxml2-utils) is missing";
  auto good = files_of(kCases + "good");
  good.push_back(source_path("deploy/module.xml"));
  const auto accepted_good = accepted_by_schema(good);
  for (const std::string& file : good) EXPECT_EQ(accepted_good.count(file), 1U) << file;

  const auto bad = files_of(kCases + "bad");
  const auto accepted_bad = accepted_by_schema(bad);
  for (const std::string& file : bad) {
    const auto expected = notes(content_of(file), "xsd: ");
    ASSERT_EQ(expected.size(), 1U) << file << " has no comment with the verdict of the schema";
    EXPECT_EQ(expected[0], accepted_bad.count(file) == 1 ? "accepts" : "rejects") << file;
  }
}

}  // namespace
}  // namespace takt::descriptor::cases_test
