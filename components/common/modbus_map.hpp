// Parses the property `map` of modbus_master and modbus_device, which assigns values of a Modbus device to
// ports. Each line describes one point; `in` and `out` are from the master's view:
//
//   lamp         out coil 0 safe 0
//   button       in  discrete 3
//   speed        out register 10 scale 0.001 unit m/s safe 0
//   temperature  in  input-register 4 int16 scale 0.1 unit degC
//   position     in  register 20 float32 order low-first      # low word in the first of the two registers
//
// Addresses are the numbers in the Modbus frames, which begin at 0. Do not use this header in real-time
// threads.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "modbus_value.hpp"

namespace modbus {

/// Maximum number of points in a map.
inline constexpr std::size_t kMaxPoints = 256;
/// The parser stops after this number of mistakes.
inline constexpr std::size_t kMostMistakes = 50;

enum class Table { coil, discrete, holding, input };
inline constexpr std::array kTables{Table::coil, Table::discrete, Table::holding, Table::input};

inline const char* to_text(Table table) noexcept {
  switch (table) {
    case Table::coil:
      return "coil";
    case Table::discrete:
      return "discrete";
    case Table::holding:
      return "register";
    case Table::input:
      return "input-register";
  }
  return "";
}
inline bool is_bit(Table table) noexcept { return table == Table::coil || table == Table::discrete; }

struct Point {
  std::string name{};  ///< name of the port for this point
  bool out = false;    ///< true: the master writes the point
  Table table = Table::coil;
  std::uint16_t address = 0;
  Encoding encoding{};  ///< used only if the point is a register
  std::string unit{};
  std::optional<double> safe{};  ///< for an output: its value when the master ends or sends no values

  /// Returns the number of bits or registers that hold the point.
  [[nodiscard]] unsigned width() const noexcept { return is_bit(table) ? 1 : words(encoding.type); }
  [[nodiscard]] unsigned end() const noexcept { return address + width(); }
};

struct Mistake {
  unsigned line = 0;  ///< line number in the map, starting at 1
  std::string what;
  std::string fix;
};

struct Map {
  std::vector<Point> points;
  std::vector<Mistake> mistakes;  ///< if not empty, do not use the points
};

/// The names of the ports of modbus_master and modbus_device that do not come from the map. No point may have
/// one of these names.
inline constexpr std::array<std::string_view, 5> kReserved{"connected", "exchanges", "failures", "clients",
                                                           "requests"};

namespace detail {

/// Returns true if the text is a valid port name in Takt.
inline bool is_name(std::string_view text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto later = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '-'; };
  return !text.empty() && text.size() <= 63 && letter(text[0]) &&
         std::all_of(text.begin(), text.end(), later);
}

/// Returns true if `c` is a control character.
inline bool is_control(char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; }

/// Converts the text to a number. Returns nothing if the text is not exactly one number.
template <class T>
std::optional<T> number(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Puts the user's text in quotes. Shortens the text and replaces unprintable characters.
inline std::string in_quotes(std::string_view text) {
  std::string result = "'";
  for (const char c : text.substr(0, 60)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > 60 ? "...'" : "'");
}

class LineReader {
 public:
  LineReader(Map& map, unsigned line, std::string_view text) : map_(map), line_(line) {
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t begin = text.find_first_not_of(kBlanks, at);
      if (begin == std::string_view::npos) break;
      at = std::min(text.find_first_of(kBlanks, begin), text.size());
      words_.push_back(text.substr(begin, at - begin));
    }
  }

  void read() {
    if (words_.empty()) return;
    const std::size_t before = map_.mistakes.size();
    if (words_.size() < 4) {
      wrong(in_quotes(words_[0]) + " is not a complete point",
            "write NAME in|out TABLE ADDRESS, as in 'lamp out coil 0'");
      return;
    }
    name();
    direction();
    const bool table_known = table();
    address();
    read_options(table_known);
    if (map_.mistakes.size() == before) check_whole();
    if (map_.mistakes.size() == before) map_.points.push_back(std::move(point_));
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r";

  void wrong(std::string what, std::string fix) {
    if (map_.mistakes.size() == kMostMistakes) return;
    map_.mistakes.push_back({line_, std::move(what), std::move(fix)});
  }

  void name() {
    point_.name = words_[0];
    if (!is_name(words_[0]))
      wrong(in_quotes(words_[0]) + " is not a valid port name",
            "use up to 63 letters, digits, '_' and '-', beginning with a letter or '_'");
    else if (std::find(kReserved.begin(), kReserved.end(), words_[0]) != kReserved.end())
      wrong("the port name " + in_quotes(words_[0]) + " is reserved", "choose another name");
    else if (std::any_of(map_.points.begin(), map_.points.end(),
                         [&](const Point& p) { return p.name == words_[0]; }))
      wrong("there are two points named " + in_quotes(words_[0]), "give each point its own name");
  }

  void direction() {
    point_.out = words_[1] == "out";
    if (!point_.out && words_[1] != "in")
      wrong(in_quotes(words_[1]) + " is not a direction",
            "write 'in' for a value that the master reads, or 'out' for a value that the master writes");
  }

  bool table() {
    for (const Table table : kTables) {
      if (words_[2] != modbus::to_text(table)) continue;
      point_.table = table;
      if (point_.out && (table == Table::discrete || table == Table::input))
        wrong(std::string{table == Table::discrete ? "a discrete input" : "an input register"} +
                  " cannot be written",
              table == Table::discrete ? "write 'in', or 'out coil'" : "write 'in', or 'out register'");
      return true;
    }
    wrong("unknown table " + in_quotes(words_[2]), "write coil, discrete, register or input-register");
    return false;
  }

  void address() {
    if (const auto address = number<std::uint16_t>(words_[3]))
      point_.address = *address;
    else
      wrong("the address cannot be " + in_quotes(words_[3]),
            "write the address as in Modbus frames, 0 to 65535 (register 40001 in a manual is 'register 0')");
  }

  void read_options(bool table_known) {
    const bool bit = table_known && is_bit(point_.table);
    for (std::size_t i = 4; i < words_.size(); ++i) {
      const std::string_view key = words_[i];
      if (const auto type = type_of(key)) {
        point_.encoding.type = *type;
        if (bit)
          wrong("a " + std::string{modbus::to_text(point_.table)} + " has no type",
                "leave out " + in_quotes(key));
        continue;
      }
      if (key != "scale" && key != "offset" && key != "unit" && key != "order" && key != "safe") {
        wrong("unknown option " + in_quotes(key),
              "write uint16, int16, uint32, int32, float32, scale X, offset X, unit U, order O or safe X");
        continue;
      }
      if (++i == words_.size()) {
        wrong(in_quotes(key) + " has no value",
              "write '" + std::string{key} + " VALUE', or leave out this option");
        return;
      }
      if (bit && key != "safe") {
        wrong("a " + std::string{modbus::to_text(point_.table)} + " has no " + std::string{key},
              "leave out this option");
        continue;
      }
      option(key, words_[i]);
    }
  }

  void option(std::string_view key, std::string_view value) {
    if (key == "unit") {
      point_.unit = value;
      if (std::any_of(value.begin(), value.end(), is_control))
        wrong("the unit " + in_quotes(value) + " contains control characters",
              "use printable characters, as in 'm/s'");
      return;
    }
    if (key == "order") {
      order_given_ = true;
      point_.encoding.low_first = value == "low-first" || value == "DCBA";
      point_.encoding.bytes_swapped = value == "BADC" || value == "DCBA";
      if (!point_.encoding.low_first && !point_.encoding.bytes_swapped && value != "high-first")
        wrong("the word order cannot be " + in_quotes(value), "write high-first, low-first, BADC or DCBA");
      return;
    }
    const auto x = number<double>(value);
    if (!x || !std::isfinite(*x) || (key == "scale" && *x == 0)) {
      wrong("the " + std::string{key} + " cannot be " + in_quotes(value),
            key == "scale" ? "write a number that is not 0" : "write a number");
      return;
    }
    if (key == "scale") point_.encoding.scale = *x;
    if (key == "offset") point_.encoding.offset = *x;
    if (key == "safe") point_.safe = *x;
  }

  /// Checks the options of the line against each other and against the points of earlier lines.
  void check_whole() {
    if (point_.end() > 65536)
      wrong("the two registers of " + in_quotes(point_.name) + " extend beyond address 65535",
            "start at 65534 or lower");
    if (order_given_ && point_.width() == 1)
      wrong("only a type with two registers has a word order",
            "leave out 'order', or use uint32, int32 or float32");
    if (point_.safe && !point_.out) wrong("an input has no safe value", "leave out 'safe'");
    if (point_.safe && is_bit(point_.table) && *point_.safe != 0 && *point_.safe != 1)
      wrong("the safe value of a coil is not 0 or 1", "write 'safe 0' or 'safe 1'");
    if (point_.safe && !is_bit(point_.table) && !fits(point_.encoding, *point_.safe))
      wrong("the safe value does not fit the type",
            "with this scale and offset the range is " + range_text(point_.encoding));
    for (const Point& other : map_.points) {
      const bool overlap =
          other.table == point_.table && other.address < point_.end() && point_.address < other.end();
      if (point_.out && other.out && overlap)
        wrong(in_quotes(point_.name) + " and " + in_quotes(other.name) + " write the same " +
                  modbus::to_text(point_.table),
              "give each point its own address");
    }
    if (map_.points.size() == kMaxPoints)
      wrong("there are more than " + std::to_string(kMaxPoints) + " points",
            "use a second module for the remaining points");
  }

  Map& map_;
  unsigned line_;
  std::vector<std::string_view> words_;
  Point point_;
  bool order_given_ = false;
};

}  // namespace detail

/// Parses any text and collects all mistakes. A line feed or ';' ends a line; '#' begins a comment.
inline Map parse_map(std::string_view text) {
  Map map;
  unsigned line = 1;
  while (!text.empty() && map.mistakes.size() < kMostMistakes) {
    const std::size_t end = std::min(text.find_first_of("\n;"), text.size());
    const bool comment_runs_on =
        end < text.size() && text[end] == ';' && text.substr(0, end).find('#') != text.npos;
    const std::size_t stop = comment_runs_on ? std::min(text.find('\n'), text.size()) : end;
    const std::string_view one = text.substr(0, stop);
    detail::LineReader{map, line, one.substr(0, one.find('#'))}.read();
    if (stop < text.size() && text[stop] == '\n') ++line;
    text.remove_prefix(std::min(stop + 1, text.size()));
  }
  if (map.points.empty() && map.mistakes.empty())
    map.mistakes.push_back(
        {1, "the map has no points", "write NAME in|out TABLE ADDRESS, as in 'lamp out coil 0'"});
  return map;
}

}  // namespace modbus
