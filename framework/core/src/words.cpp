#include <takt/core/words.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <unordered_set>

#include <takt/core/control_character.hpp>

namespace takt {

namespace {

constexpr std::size_t kLongestQuote = 80;
constexpr std::size_t kMostChoicesNamed = 20;
constexpr std::size_t kMostChoicesTried = 1000;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Returns the edit distance of two words: how many letters must be changed, inserted, removed or swapped
/// with their neighbour to turn word `a` into word `b`. Returns `limit` + 1 if the distance exceeds `limit`.
/// The algorithm fills a table of distances between beginnings of the two words. It skips the cells that are
/// more than `limit` away from the diagonal, because their values exceed `limit`.
std::size_t distance(std::string_view a, std::string_view b, std::size_t limit) {
  const std::size_t apart = a.size() > b.size() ? a.size() - b.size() : b.size() - a.size();
  if (apart > limit) return limit + 1;

  const std::size_t far = limit + 1;
  std::vector<std::size_t> above_that(b.size() + 2, far);
  std::vector<std::size_t> above(b.size() + 2, far);
  std::vector<std::size_t> row(b.size() + 2, far);
  for (std::size_t j = 0; j <= std::min(b.size(), limit); ++j) above[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    const std::size_t first = i > limit ? i - limit : 1;
    const std::size_t last = std::min(b.size(), i + limit);
    row[first - 1] = first == 1 ? std::min(i, far) : far;
    row[last + 1] = far;
    std::size_t least = row[first - 1];
    for (std::size_t j = first; j <= last; ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (same ? 0U : 1U), far});
      const bool swapped =
          i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], above_that[j - 2] + 1);
      least = std::min(least, row[j]);
    }
    if (least > limit) return far;
    above_that.swap(above);
    above.swap(row);
  }
  return above[b.size()];
}

}  // namespace

bool is_control_character(std::string_view character) noexcept {
  const auto byte = [character](std::size_t i) {
    return i < character.size() ? static_cast<unsigned char>(character[i]) : 0U;
  };
  const unsigned second = byte(1);
  const unsigned third = byte(2);
  switch (byte(0)) {
    case 0xc2:
      return second < 0xa0;  // U+0080-009F
    case 0xd8:
      return second == 0x9c;  // U+061C, Arabic letter mark
    case 0xe2:                // U+200E-200F, U+2028-202E, U+2066-2069
      return (second == 0x80 && (third == 0x8e || third == 0x8f || (third >= 0xa8 && third <= 0xae))) ||
             (second == 0x81 && third >= 0xa6 && third <= 0xa9);
    default:
      return byte(0) < 0x20 || byte(0) == 0x7f;
  }
}

std::size_t utf8_length(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [text](std::size_t i) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i]));
  };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < length) return 0;
  std::uint32_t code = first & (0x7fU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0U) != 0x80U) return 0;
    code = code << 6U | (byte(i) & 0x3fU);
  }
  if ((length == 3 && code < 0x800) || (length == 4 && code < 0x10000)) return 0;
  if (code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff)) return 0;
  return length;
}

std::string on_one_line(std::string_view text) {
  std::string line;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    if (length != 0 && !is_control_character(character)) {
      line += character;
    } else if (character == "\n") {
      line += "\\n";
    } else {
      for (const char c : character) {
        std::array<char, 5> escaped{};
        std::snprintf(escaped.data(), escaped.size(), "\\x%02x",
                      static_cast<unsigned>(static_cast<unsigned char>(c)));
        line += escaped.data();
      }
    }
    text.remove_prefix(character.size());
  }
  return line;
}

std::string xml_reference(std::string_view character) {
  std::uint32_t code = static_cast<unsigned char>(character[0]);
  if (const std::size_t length = utf8_length(character); length > 1) {
    code &= 0x7fU >> length;
    for (std::size_t i = 1; i < length; ++i)
      code = code << 6U | (static_cast<unsigned char>(character[i]) & 0x3fU);
  } else if (length == 0 || (code < 0x20 && code != '\t' && code != '\n' && code != '\r')) {
    return on_one_line(character);
  }
  std::array<char, 16> reference{};
  std::snprintf(reference.data(), reference.size(), "&#x%x;", code);
  return reference.data();
}

std::string brief(std::string_view text) {
  if (text.size() <= kLongestQuote) return on_one_line(text);
  // Cut only between characters, because half a character would be invalid UTF-8.
  const auto continues = [text](std::size_t i) {
    return (static_cast<unsigned char>(text[i]) & 0xc0U) == 0x80U;
  };
  std::size_t head = kLongestQuote / 2;
  std::size_t tail = text.size() - kLongestQuote / 4;
  for (int i = 0; i < 3 && continues(head); ++i) --head;
  for (int i = 0; i < 3 && continues(tail); ++i) ++tail;
  return on_one_line(text.substr(0, head)) + "..." + on_one_line(text.substr(tail));
}

std::string in_quotes(std::string_view text) { return "'" + brief(text) + "'"; }

std::string location(std::string_view file, int line) {
  const std::string number = std::to_string(std::max(line, 1));
  return file.empty() ? "line " + number : on_one_line(file) + ":" + number;
}

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& choices) {
  std::string_view best;
  std::size_t limit = std::clamp<std::size_t>((word.size() + 1) / 3, 1, 3);
  if (word.size() < 2) limit = 0;
  const std::size_t tried = std::min(choices.size(), kMostChoicesTried);
  for (std::size_t i = 0; i < tried; ++i) {
    const std::size_t far = distance(word, choices[i], limit);
    if (far > limit) continue;
    best = choices[i];
    if (far == 0) break;
    limit = far - 1;
  }
  return best;
}

namespace {
/// Returns each text once, in the order of first appearance.
std::vector<std::string_view> without_repeats(const std::vector<std::string_view>& all) {
  std::vector<std::string_view> once;
  std::unordered_set<std::string_view> seen;
  seen.reserve(all.size());
  for (const std::string_view one : all) {
    if (seen.insert(one).second) once.push_back(one);
  }
  return once;
}

std::string listed(const std::vector<std::string_view>& choices) {
  std::string text;
  const std::size_t named = std::min(choices.size(), kMostChoicesNamed);
  for (std::size_t i = 0; i < named; ++i) {
    if (i > 0) text += i + 1 == choices.size() ? " or " : ", ";
    text += brief(choices[i]);
  }
  if (named < choices.size()) text += " and " + std::to_string(choices.size() - named) + " more";
  return text;
}
}  // namespace

std::string one_of(const std::vector<std::string_view>& all) { return listed(without_repeats(all)); }

std::string suggestion(std::string_view word, const std::vector<std::string_view>& choices) {
  const std::string_view meant = nearest(word, choices);
  if (!meant.empty()) return "did you mean " + brief(meant) + "?";
  const std::vector<std::string_view> once = without_repeats(choices);
  return "use " + listed(once);
}

}  // namespace takt
