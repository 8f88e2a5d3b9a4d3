// Functions that read and check the SVG of drawings.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace takt::tool::drawings {

inline std::size_t occurrences(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

inline bool is_well_formed(const std::string& drawing) {
  const auto file =
      std::filesystem::path{testing::TempDir()} / ("takt_picture_" + std::to_string(::getpid()) + ".svg");
  std::ofstream{file} << drawing;
  const bool right = std::system(("xmllint --noout " + file.string()).c_str()) == 0;
  std::filesystem::remove(file);
  return right;
}

/// A text in a drawing, with its position and with its size if the font is wide.
struct Label {
  double left = 0;
  double right = 0;
  double baseline = 0;
  double size = 0;
  std::string words;
};

inline std::vector<Label> labels(const std::string& drawing) {
  static const std::regex kText{
      R"re(<text x="([-0-9.]+)" y="([-0-9.]+)" font-size="([0-9.]+)" text-anchor="(\w+)" class="[^"]*">([^<]*)</text>)re"};
  std::vector<Label> found;
  for (std::sregex_iterator at{drawing.begin(), drawing.end(), kText}, end; at != end; ++at) {
    Label label{.baseline = std::stod((*at)[2]), .size = std::stod((*at)[3]), .words = (*at)[5]};
    const double width = static_cast<double>(label.words.size()) * label.size * 0.61;
    const std::string anchor = (*at)[4];
    label.left = std::stod((*at)[1]) - (anchor == "middle" ? width / 2 : anchor == "end" ? width : 0);
    label.right = label.left + width;
    found.push_back(std::move(label));
  }
  return found;
}

inline bool overlap(const Label& a, const Label& b) {
  return a.left < b.right && b.left < a.right && a.baseline - 0.75 * a.size < b.baseline + 0.2 * b.size &&
         b.baseline - 0.75 * b.size < a.baseline + 0.2 * a.size;
}

/// Expects that every text is within the drawing and that no two texts overlap.
inline void expect_readable(const std::string& drawing) {
  std::smatch box;
  ASSERT_TRUE(std::regex_search(drawing, box, std::regex{R"re(viewBox="0 0 (\d+) (\d+)")re"}));
  const auto all = labels(drawing);
  ASSERT_EQ(all.size(), occurrences(drawing, "<text "));
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_GE(all[i].left, 0) << all[i].words;
    EXPECT_LE(all[i].right, std::stod(box[1])) << all[i].words;
    EXPECT_LE(all[i].baseline, std::stod(box[2])) << all[i].words;
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      ASSERT_FALSE(overlap(all[i], all[j])) << all[i].words << " and " << all[j].words;
    }
  }
}

}  // namespace takt::tool::drawings
