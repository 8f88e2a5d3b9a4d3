// Parses arbitrary bytes as the description of a type, and as a sample of a type. The parser must either
// report problems or return a type within the limits. Printing and parsing this type must not change it. A
// sample must either be invalid, or survive being printed as JSON and built again from the JSON.
//
// An input that begins with a digit is a sample of the type with that index in kTypes. Any other input is a
// description up to the first line feed, followed by a sample as bytes or as JSON.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/check.hpp>
#include <takt/core/words.hpp>
#include <takt/model/type.hpp>

namespace {

using takt::model::Type;

constexpr std::array<std::string_view, 3> kTypes{
    R"({"name":"a::Part","fields":[{"name":"kind","type":"octet"},{"name":"number","type":"unsigned long long"},)"
    R"({"name":"label","type":"string","bound":7},{"name":"good","type":"boolean","array":[2]}]})",
    R"({"name":"Way","fields":[{"name":"mode","type":"enum","of":"Mode","enumerators":["OFF","ON"],"sequence":3},)"
    R"({"name":"way","type":"double","array":[2],"sequence":2,"elements":[3]},{"name":"letter","type":"char"}]})",
    R"({"name":"Names","fields":[{"name":"each","type":"struct","of":"Name","sequence":4,"fields":[)"
    R"({"name":"text","type":"string","bound":3,"array":[2]},{"name":"at","type":"float"},{"name":"n","type":"short"}]},)"
    R"({"name":"last","type":"long long"}]})",
};

bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = takt::utf8_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

/// Maximum size, in bytes, of the types whose samples the fuzzer builds. Samples of larger types take long to
/// build and find no other bugs.
constexpr std::size_t kLarge = 64 * 1024;

void check_sample(const Type& type, std::string_view input) {
  const auto* bytes = reinterpret_cast<const std::byte*>(input.data());
  const bool is_sample = takt::model::is_sample(type, bytes, input.size());
  if (is_sample) {
    TAKT_CHECK(input.size() <= takt::model::max_size(type) + 3);
    const std::string json = takt::model::sample_json(type, bytes, input.size());
    TAKT_CHECK(is_utf8(json) && json.find('\n') == std::string::npos);
    if (takt::model::max_size(type) > kLarge) return;
    const auto again = takt::model::sample_bytes(type, json);
    // sample_json() prints a byte that is not valid UTF-8 as three bytes, which may exceed the bound of a
    // string.
    if (!again.ok()) return TAKT_CHECK(json.find("\xEF\xBF\xBD") != std::string::npos);
    TAKT_CHECK(takt::model::is_sample(type, again->data(), again->size()));
    TAKT_CHECK(takt::model::sample_json(type, again->data(), again->size()) == json);
  } else if (takt::model::max_size(type) <= kLarge) {
    const auto made = takt::model::sample_bytes(type, std::string{input});
    if (made.ok()) {
      TAKT_CHECK(takt::model::is_sample(type, made->data(), made->size()));
    } else {
      TAKT_CHECK(!made.problems().empty());
      for (const takt::Problem& problem : made.problems())
        TAKT_CHECK(!problem.what.empty() && !problem.where.empty());
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input{reinterpret_cast<const char*>(data), size};
  if (!input.empty() && input[0] >= '0' && input[0] < static_cast<char>('0' + kTypes.size())) {
    static const std::array<Type, 3> types{takt::model::parse_type(std::string{kTypes[0]}).value(),
                                           takt::model::parse_type(std::string{kTypes[1]}).value(),
                                           takt::model::parse_type(std::string{kTypes[2]}).value()};
    check_sample(types.at(static_cast<std::size_t>(input[0] - '0')), input.substr(1));
    return 0;
  }
  const std::size_t end = std::min(input.find('\n'), input.size());
  const auto type = takt::model::parse_type(std::string{input.substr(0, end)});
  if (!type.ok()) {
    TAKT_CHECK(!type.problems().empty() && type.problems().size() <= 100);
    for (const takt::Problem& problem : type.problems())
      TAKT_CHECK(!problem.where.empty() && is_utf8(to_text(problem)));
    return 0;
  }
  TAKT_CHECK(takt::model::max_size(*type) <= takt::model::kMaxSampleSize);
  const auto again = takt::model::parse_type(to_text(*type));
  TAKT_CHECK(again.ok() && *again == *type);
  check_sample(*type, input.substr(std::min(end + 1, input.size())));
  return 0;
}
