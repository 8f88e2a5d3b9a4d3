#include <takt/model/profile_json.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>

namespace takt::model {

namespace {

using Json = nlohmann::ordered_json;

/// One statistic of a module's run times. kTimes lists all of them in ascending order.
struct Time {
  const char* key;
  Nanoseconds RunTimes::*of;
};
constexpr std::array kTimes{Time{"min_ns", &RunTimes::min}, Time{"p50_ns", &RunTimes::p50},
                            Time{"p99_ns", &RunTimes::p99}, Time{"p999_ns", &RunTimes::p999},
                            Time{"max_ns", &RunTimes::max}};
constexpr const char* kRewrite = "write the file again with takt run --profile";

class ProfileReader {
 public:
  ProfileReader(std::string_view text, std::string_view file) : text_(text), file_(file) {}

  Result<Profile> read();

 private:
  void add(int line, std::string what, std::string fix) {
    problems_.push_back({takt::location(file_, line), std::move(what), std::move(fix)});
  }
  [[nodiscard]] int line_at(std::size_t offset) const {
    const auto before = text_.substr(0, offset);
    return 1 + static_cast<int>(std::count(before.begin(), before.end(), '\n'));
  }
  /// Returns the line on which a key first occurs in the text; 1 if the key is written with escapes.
  [[nodiscard]] int line_of(const std::string& key) const {
    const std::size_t found = text_.find('"' + key + '"');
    return found == std::string_view::npos ? 1 : line_at(found);
  }
  void read_module(const std::string& name, const Json& value);
  /// Returns `value` if it is a whole number from 0 to 2^63 - 1. Otherwise reports a problem and returns 0.
  std::int64_t number(const std::string& module, const Json& value, const char* key);
  void reject_unknown(const Json& object, const std::vector<std::string_view>& known,
                      const std::string& whose, int line);

  std::string_view text_;
  std::string_view file_;
  Profile profile_;
  Problems problems_;
};

void ProfileReader::reject_unknown(const Json& object, const std::vector<std::string_view>& known,
                                   const std::string& whose, int line) {
  for (const auto& [key, value] : object.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      add(line, "unknown member " + in_quotes(key) + " in " + whose, suggestion(key, known));
  }
}

std::int64_t ProfileReader::number(const std::string& module, const Json& value, const char* key) {
  const auto found = value.find(key);
  const int line = line_of(module);
  if (found == value.end()) {
    add(line, in_quotes(module) + " has no \"" + key + "\"", kRewrite);
  } else if (!found->is_number_unsigned() ||
             found->get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()}) {
    add(line, "\"" + std::string{key} + "\" of " + in_quotes(module) + " is " + brief(found->dump()),
        "write a whole number from 0 to 2^63 - 1");
  } else {
    return found->get<std::int64_t>();
  }
  return 0;
}

void ProfileReader::read_module(const std::string& name, const Json& value) {
  const int line = line_of(name);
  const std::size_t dot = name.find('.');
  if (dot == 0 || dot == std::string::npos || dot + 1 == name.size() ||
      name.find('.', dot + 1) != std::string::npos) {
    add(line, in_quotes(name) + " is not the name of a module", "write it as \"device.module\"");
  }
  if (!value.is_object()) {
    add(line, in_quotes(name) + " has no run times", R"(write an object with "runs", "min_ns" and so on)");
    return;
  }
  const std::size_t before = problems_.size();
  RunTimes times;
  times.runs = static_cast<std::uint64_t>(number(name, value, "runs"));
  std::vector<std::string_view> known{"runs"};
  for (const Time& time : kTimes) {
    times.*time.of = Nanoseconds{number(name, value, time.key)};
    known.emplace_back(time.key);
  }
  reject_unknown(value, known, in_quotes(name), line);
  if (problems_.size() != before) return;
  for (std::size_t i = 1; i < kTimes.size(); ++i) {
    if (times.*kTimes[i - 1].of <= times.*kTimes[i].of) continue;
    add(line,
        "\"" + std::string{kTimes[i - 1].key} + "\" of " + in_quotes(name) + " is larger than \"" +
            kTimes[i].key + "\"",
        "write times that do not decrease from min_ns to max_ns");
  }
  profile_.modules[name] = times;
}

Result<Profile> ProfileReader::read() {
  Json root;
  try {
    root = Json::parse(text_);
  } catch (const Json::parse_error& error) {
    add(line_at(error.byte == 0 ? 0 : error.byte - 1), "the file is not JSON", kRewrite);
    return problems_;
  }
  if (!root.is_object()) {
    add(1, "the file is not a profile", kRewrite);
    return problems_;
  }
  reject_unknown(root, {"cell", "machine", "modules"}, "a profile", 1);
  if (const auto cell = root.find("cell"); cell == root.end() || !cell->is_string()) {
    add(line_of("cell"), "the profile does not name its cell", R"(add "cell": "NAME")");
  } else {
    profile_.cell = cell->get<std::string>();
  }
  if (const auto machine = root.find("machine"); machine != root.end() && !machine->is_object())
    add(line_of("machine"), "the value of \"machine\" is not a JSON object", kRewrite);
  const auto modules = root.find("modules");
  if (modules == root.end() || !modules->is_object()) {
    add(line_of("modules"), "the profile has no \"modules\" object", kRewrite);
  } else {
    for (const auto& [name, value] : modules->items()) read_module(name, value);
  }
  if (!problems_.empty()) return problems_;
  return std::move(profile_);
}

}  // namespace

std::string profile_json(const Profile& profile, const std::map<std::string, std::string>& machine) {
  Json modules = Json::object();
  for (const auto& [name, times] : profile.modules) {
    Json& entry = modules[name] = {{"runs", times.runs}};
    for (const Time& time : kTimes) entry[time.key] = (times.*time.of).count();
  }
  const Json root{{"cell", profile.cell}, {"machine", machine}, {"modules", modules}};
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Profile> parse_profile(std::string_view text, std::string_view file) {
  return ProfileReader{text, file}.read();
}

}  // namespace takt::model
