#include "web/incoming_request.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>
#include <system_error>

#include <takt/core/time.hpp>
#include <takt/core/words.hpp>

namespace takt::tool::web {

namespace {

constexpr std::string_view kLineEnd = "\r\n";

std::string lower(std::string_view text) {
  std::string result{text};
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::string_view trim(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

bool has_control_character(std::string_view line) {
  return std::any_of(line.begin(), line.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < ' ' && byte != '\t') || byte == 0x7F;
  });
}

bool is_number(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

IncomingRequest::State IncomingRequest::reject(int status, const std::string& what, const std::string& fix) {
  rejection_ = answer_of(status, {.where = "", .what = what, .fix = fix});
  return State::rejected;
}

void IncomingRequest::expire() {
  reject(408, "the request did not arrive within " + to_text(Nanoseconds{kLimit}),
         "send the request again, faster");
}

IncomingRequest::State IncomingRequest::take(std::string_view bytes) {
  const std::size_t before = arrived_.size();
  arrived_ += bytes.substr(0, kMostHead + kMostBody - before);
  if (body_at_ == 0) {
    constexpr std::string_view kEnd = "\r\n\r\n";
    if (std::min(arrived_.find(kLineEnd), arrived_.size()) > kMostLine)
      return reject(414, "the address in the request is too long",
                    "send at most " + std::to_string(kMostLine) + " bytes in the first line");
    const std::size_t end = arrived_.find(kEnd, before - std::min(before, kEnd.size() - 1));
    if (std::min(end, arrived_.size()) > kMostHead - kEnd.size())
      return reject(431, "the header lines of the request are too long",
                    "send at most " + std::to_string(kMostHead >> 10) + " KiB before the body");
    if (end == std::string::npos) return State::incomplete;
    body_at_ = end + kEnd.size();
    if (const State state = read_head({arrived_.data(), end}); state == State::rejected) return state;
  }
  if (arrived_.size() - body_at_ < body_size_) return State::incomplete;
  text_.append(arrived_, body_at_, body_size_);
  arrived_ = {};
  return State::complete;
}

// Reads the lines before the body. Writes the lines for the library to text_, and the length of the body to
// body_size_.
IncomingRequest::State IncomingRequest::read_head(std::string_view head) {
  std::optional<std::size_t> length;
  for (std::size_t begin = 0; begin <= head.size();) {
    const std::size_t end = std::min(head.find(kLineEnd, begin), head.size());
    const std::string_view line = head.substr(begin, end - begin);
    const bool first = begin == 0;
    begin = end + kLineEnd.size();
    const std::size_t colon = line.find(':');
    const std::string name = lower(line.substr(0, std::min(colon, line.size())));
    const bool is_header =
        colon != std::string_view::npos && colon > 0 && name.find_first_of(" \t") == std::string::npos;
    if (has_control_character(line) || (!first && !is_header))
      return reject(400, "the request is malformed: " + in_quotes(line), "send an HTTP request");
    if (first || name == "host" || name == "authorization" || name == "accept-encoding") {
      text_.append(line).append(kLineEnd);
    } else if (name == "transfer-encoding") {
      return reject(411, "the body is sent in chunks", "send the body with the header Content-Length");
    } else if (name == "content-encoding") {
      return reject(415, "the body is compressed", "send the body uncompressed");
    } else if (name == "content-length") {
      const std::string_view value = trim(line.substr(colon + 1));
      if (length || !is_number(value))
        return reject(400, "the request is malformed: " + in_quotes(line),
                      "send the header Content-Length once, with the number of bytes of the body");
      std::size_t number = 0;
      const auto read = std::from_chars(value.data(), value.data() + value.size(), number);
      if (read.ec != std::errc{} || number > kMostBody)
        return reject(413, "the request is too long",
                      "send at most " + std::to_string(kMostBody >> 10) + " KiB");
      length = number;
    }
  }
  const bool sends_body = head.starts_with("POST ") || head.starts_with("PUT ");
  if (sends_body && !length)
    return reject(411, "the request does not say how long its body is", "send the header Content-Length");
  body_size_ = length.value_or(0);
  text_ += "Content-Length: " + std::to_string(body_size_) + "\r\n\r\n";
  return State::incomplete;
}

}  // namespace takt::tool::web
