#include "well_formed.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>

#include <takt/core/words.hpp>
#include "tree.hpp"

namespace takt::descriptor {

namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool is_blank(char c) { return kBlanks.find(c) != std::string_view::npos; }

// Accepts every character beyond ASCII as a letter. Names with such characters are rejected later, because no
// known element or attribute has such a name.
bool starts_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == ':' ||
         (static_cast<unsigned char>(c) & 0x80U) != 0;
}
bool continues_name(char c) { return starts_name(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; }

bool is_xml_character(std::uint32_t code) {
  if (code < 0x20) return code == 0x09 || code == 0x0a || code == 0x0d;
  return code <= 0x10ffff && (code < 0xd800 || code > 0xdfff) && code != 0xfffe && code != 0xffff;
}

int line_at(std::string_view xml, std::size_t position) {
  return 1 +
         static_cast<int>(std::count(xml.begin(), xml.begin() + static_cast<std::ptrdiff_t>(position), '\n'));
}

std::optional<SyntaxError> find_bad_byte(std::string_view xml) {
  const auto error = [&](std::size_t at, std::string what, std::string fix) {
    return SyntaxError{line_at(xml, at), std::move(what), std::move(fix)};
  };
  if (xml.starts_with("\x7f"
                      "ELF")) {
    return error(0, "the file is a program or a shared object, not a descriptor",
                 "give the path of an XML file; takt describe shows what a component offers");
  }
  if (xml.starts_with("\xff\xfe") || xml.starts_with("\xfe\xff")) {
    return error(0, "the file is encoded as UTF-16", "save it as UTF-8");
  }
  for (std::size_t at = 0; at < xml.size();) {
    const std::string_view rest = xml.substr(at);
    const std::size_t length = utf8_length(rest);
    if (length == 0) {
      return error(at, "the file is not UTF-8: it has the byte " + in_quotes(rest.substr(0, 1)),
                   "save it as UTF-8");
    }
    const std::string_view character = rest.substr(0, length);
    const auto byte = static_cast<unsigned char>(character[0]);
    if (length == 1 && byte == 0)
      return error(at, "the file has a zero byte", "a descriptor is text, saved as UTF-8");
    const bool allowed =
        (length > 1 || is_xml_character(byte)) && character != "\xef\xbf\xbe" && character != "\xef\xbf\xbf";
    if (!allowed) {
      return error(at, "the file has a control character " + in_quotes(character),
                   "XML does not allow this character: remove it");
    }
    at += length;
  }
  return std::nullopt;
}

/// Scans the text from the beginning to the end, or to the first error.
class Scanner {
 public:
  Scanner(std::string_view xml, std::vector<Span>* models) : xml_(xml), models_(models) {}
  std::optional<SyntaxError> run();

 private:
  struct Open {
    std::string_view name;
    int line;
  };

  bool scan_declaration();
  bool scan_declared(std::string_view name, std::string_view value);
  bool scan_markup();
  bool scan_model();
  bool scan_comment();
  bool scan_cdata();
  bool scan_text();
  bool scan_start_tag();
  bool scan_end_tag();
  bool scan_attribute(std::vector<std::string_view>& seen);
  bool scan_reference(std::string_view text, std::size_t& at, int line);

  bool fail(int line, std::string what, std::string fix) {
    error_ = SyntaxError{line, std::move(what), std::move(fix)};
    return false;
  }
  bool fail(std::string what, std::string fix) { return fail(line_, std::move(what), std::move(fix)); }

  /// Counts one more part of the document that tinyxml2 will store. Fails if there are too many parts.
  bool count_part() {
    if (++parts_ <= kMaxParts) return true;
    return fail(
        "the file has more than " + std::to_string(kMaxParts) + " elements, attributes, texts and comments",
        "a descriptor has far fewer: is this the right file?");
  }

  [[nodiscard]] bool done() const { return at_ == xml_.size(); }
  [[nodiscard]] std::string_view rest() const { return xml_.substr(at_); }
  [[nodiscard]] bool next_is(std::string_view word) const { return rest().starts_with(word); }
  void advance(std::size_t count) {
    line_ += static_cast<int>(std::count(xml_.begin() + static_cast<std::ptrdiff_t>(at_),
                                         xml_.begin() + static_cast<std::ptrdiff_t>(at_ + count), '\n'));
    at_ += count;
  }
  bool skip_blanks() {
    const std::size_t blanks = std::min(rest().find_first_not_of(kBlanks), rest().size());
    advance(blanks);
    return blanks > 0;
  }
  std::string_view take_name() {
    std::size_t length = 0;
    const std::string_view text = rest();
    if (!text.empty() && starts_name(text[0])) {
      while (length < text.size() && continues_name(text[length])) ++length;
    }
    advance(length);
    return text.substr(0, length);
  }
  /// Describes the next character, for a message.
  [[nodiscard]] std::string found() const {
    return done() ? "the end of the file"
                  : in_quotes(rest().substr(0, std::max<std::size_t>(1, utf8_length(rest()))));
  }

  std::string_view xml_;
  std::vector<Span>* models_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::vector<Open> open_;
  bool root_seen_ = false;
  std::size_t parts_ = 0;
  std::optional<SyntaxError> error_;
};

std::optional<SyntaxError> Scanner::run() {
  if (next_is(kByteOrderMark)) advance(kByteOrderMark.size());
  if (rest().find_first_not_of(kBlanks) == std::string_view::npos) {
    fail("the file is empty", "the root element of a descriptor must be <root> or <cell>");
    return error_;
  }
  if (next_is("<?xml") && rest().size() > 5 && is_blank(rest()[5]) && !scan_declaration()) return error_;
  while (!done()) {
    if (!(next_is("<") ? scan_markup() : scan_text())) return error_;
  }
  if (!open_.empty()) {
    fail(open_.back().line, "<" + brief(open_.back().name) + "> is not closed before the end of the file",
         "close it with </" + brief(open_.back().name) + ">");
  } else if (!root_seen_) {
    fail("the file has no root element", "the root element of a descriptor must be <root> or <cell>");
  }
  return error_;
}

bool Scanner::scan_declared(std::string_view name, std::string_view value) {
  if (name == "version" && value != "1.0")
    return fail("XML version " + in_quotes(value) + " is not supported", "write version=\"1.0\"");
  if (name == "encoding") {
    std::string upper{value};
    for (char& c : upper) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    if (upper != "UTF-8")
      return fail("encoding " + in_quotes(value) + " is not supported",
                  "save the file as UTF-8 and write encoding=\"UTF-8\"");
  }
  if (name == "standalone" && value != "yes" && value != "no") {
    return fail("standalone is " + in_quotes(value), "use yes or no");
  }
  return true;
}

/// Scans the XML declaration, for example <?xml version="1.0" encoding="UTF-8" standalone="yes"?>. `encoding`
/// and `standalone` may be omitted, but must be in this order.
bool Scanner::scan_declaration() {
  constexpr const char* kRight = "write <?xml version=\"1.0\" encoding=\"UTF-8\"?>";
  advance(5);
  bool first = true;
  for (const std::string_view expected : {"version", "encoding", "standalone"}) {
    const bool blank = skip_blanks();
    if (!next_is(expected) || !blank) {
      if (first) return fail("the XML declaration has no version", kRight);
      continue;
    }
    first = false;
    take_name();
    skip_blanks();
    if (!next_is("=")) return fail("= is missing in the XML declaration", kRight);
    advance(1);
    skip_blanks();
    const char quote = done() ? '\0' : rest()[0];
    const std::size_t end = quote == '"' || quote == '\'' ? rest().find(quote, 1) : std::string_view::npos;
    if (end == std::string_view::npos) return fail("a value in the XML declaration is not in quotes", kRight);
    const std::string_view value = rest().substr(1, end - 1);
    if (!scan_declared(expected, value)) return false;
    advance(end + 1);
  }
  skip_blanks();
  if (!next_is("?>")) return fail("the XML declaration does not end with ?> but with " + found(), kRight);
  advance(2);
  return true;
}

bool Scanner::scan_markup() {
  if (next_is("<!--")) return scan_comment() && count_part();
  if (next_is("<![CDATA[")) return scan_cdata() && count_part();
  if (next_is("<!")) {
    return fail("a document type or entity declaration (<!DOCTYPE, <!ENTITY) is not allowed",
                "remove it: a descriptor has elements and comments only");
  }
  if (next_is("<?xml-model") && rest().size() > 11 && is_blank(rest()[11]))
    return scan_model() && count_part();
  if (next_is("<?")) {
    return fail(
        "a processing instruction (<?...) is not allowed",
        "remove it: only the XML declaration, at the start of the file, and <?xml-model?> are allowed");
  }
  return next_is("</") ? scan_end_tag() : scan_start_tag() && count_part();
}

/// Scans <?xml-model href="..."?>, which tells editors where the schema is. Takt does not open the schema.
bool Scanner::scan_model() {
  if (root_seen_)
    return fail("<?xml-model?> after the start of the root element", "move it before the root element");
  const std::size_t end = rest().find("?>");
  if (end == std::string_view::npos) return fail("<?xml-model is not closed", "close it with ?>");
  if (models_ != nullptr) models_->push_back({at_, end + 2});
  advance(end + 2);
  return true;
}

bool Scanner::scan_comment() {
  const std::size_t dashes = rest().find("--", 4);
  if (dashes == std::string_view::npos) return fail("a comment is not closed", "close it with -->");
  const bool closed = rest().substr(dashes).starts_with("-->");
  const int line = line_at(rest(), dashes) + line_ - 1;
  if (!closed) return fail(line, "-- inside a comment", "a comment ends with --> and has no -- before that");
  advance(dashes + 3);
  return true;
}

bool Scanner::scan_cdata() {
  if (open_.empty()) return fail("text outside the root element", "remove it, or write it as a comment");
  const std::size_t end = rest().find("]]>");
  if (end == std::string_view::npos) return fail("a CDATA section is not closed", "close it with ]]>");
  advance(end + 3);
  return true;
}

bool Scanner::scan_text() {
  const std::string_view text = rest().substr(0, rest().find('<'));
  const std::size_t start = text.find_first_not_of(kBlanks);
  if (open_.empty() && start != std::string_view::npos) {
    if (at_ == 0) {
      return fail(
          line_at(text, start) + line_ - 1,
          "the file is not XML: it begins with " + in_quotes(trimmed(text.substr(0, text.find('\n', start)))),
          "give the path of a descriptor, which is an XML file");
    }
    return fail(line_at(text, start) + line_ - 1,
                "text outside the root element: " +
                    in_quotes(text.substr(start, text.find_last_not_of(kBlanks) + 1 - start)),
                "remove it, or write it as a comment");
  }
  int line = line_;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '\n') ++line;
    if (text[at] == '&') {
      if (!scan_reference(text, at, line)) return false;
    } else if (text.substr(at).starts_with("]]>")) {
      return fail(line, "]]> in a text", "write ]]&gt;");
    } else {
      ++at;
    }
  }
  advance(text.size());
  // A text of only white space does not count as a part, because tinyxml2 does not store it.
  return start == std::string_view::npos || count_part();
}

/// Scans a reference such as &amp;. `at` is the index of the &; scan_reference() moves it to the character
/// after the reference.
bool Scanner::scan_reference(std::string_view text, std::size_t& at, int line) {
  const std::size_t end = text.find(';', at);
  const std::string_view name = end == std::string_view::npos ? "" : text.substr(at + 1, end - at - 1);
  if (name.starts_with('#')) {
    const bool hex = name.starts_with("#x");
    const std::string_view digits = name.substr(hex ? 2 : 1);
    std::uint32_t code = 0;
    const auto [last, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), code, hex ? 16 : 10);
    // Allow at most 8 digits, because tinyxml2 reads at most ten characters of a reference.
    const bool number = error == std::errc{} && last == digits.data() + digits.size() && digits.size() <= 8;
    if (!number || !is_xml_character(code)) {
      return fail(line, in_quotes("&" + std::string{name} + ";") + " is not a character",
                  "give its code, as in &#65; or &#x41;");
    }
  } else if (name != "amp" && name != "lt" && name != "gt" && name != "quot" && name != "apos") {
    const bool is_word = !name.empty() && std::all_of(name.begin(), name.end(), continues_name);
    if (!is_word) return fail(line, "& on its own", "write &amp;");
    return fail(line, "unknown entity " + in_quotes("&" + std::string{name} + ";"),
                "XML has only &amp; &lt; &gt; &quot; and &apos;");
  }
  at = end + 1;
  return true;
}

bool Scanner::scan_attribute(std::vector<std::string_view>& seen) {
  const std::string_view name = take_name();
  if (name.empty())
    return fail("found " + found() + " in a tag", "write name=\"value\" and close the tag with > or />");
  if (std::find(seen.begin(), seen.end(), name) != seen.end()) {
    return fail("duplicate attribute " + in_quotes(name), "write it only once");
  }
  seen.push_back(name);
  const std::string right = "write " + brief(name) + "=\"value\"";
  skip_blanks();
  if (!next_is("=")) return fail("attribute " + in_quotes(name) + " has no value", right);
  advance(1);
  skip_blanks();
  const char quote = done() ? '\0' : rest()[0];
  if (quote != '"' && quote != '\'') {
    return fail("the value of attribute " + in_quotes(name) + " is not in quotes", right);
  }
  const std::size_t end = rest().find(quote, 1);
  const std::string_view value = rest().substr(1, end == std::string_view::npos ? end : end - 1);
  // If the closing quote is missing, the value continues to the next quote in the file, so it contains a <.
  if (end == std::string_view::npos || value.find('<') != std::string_view::npos) {
    return fail("the value of attribute " + in_quotes(name) + " does not end, or contains a <",
                "close it with " + std::string(1, quote) + "; a < in a value is written &lt;");
  }
  int line = line_;
  for (std::size_t at = 0; at < value.size();) {
    if (value[at] == '\n') ++line;
    if (value[at] != '&') {
      ++at;
    } else if (!scan_reference(value, at, line)) {
      return false;
    }
  }
  advance(end + 1);
  return true;
}

bool Scanner::scan_start_tag() {
  const int line = line_;
  advance(1);
  const std::string_view name = take_name();
  if (name.empty())
    return fail("< is followed by " + found(), "a tag begins with a name; a < in a text is written &lt;");
  if (open_.empty() && root_seen_) {
    return fail("a second root element <" + brief(name) + ">",
                "a descriptor has one root element: put everything into it");
  }
  if (open_.size() >= kMaxDepth) {
    return fail("elements are nested more than " + std::to_string(kMaxDepth) + " levels deep",
                "a descriptor needs fewer than ten levels");
  }
  root_seen_ = true;

  std::vector<std::string_view> attributes;
  while (true) {
    const bool blank = skip_blanks();
    if (done()) return fail(line, "the tag <" + brief(name) + " is not closed", "close it with > or />");
    if (next_is("/>")) {
      advance(2);
      return true;
    }
    if (next_is(">")) {
      advance(1);
      open_.push_back({name, line});
      return true;
    }
    if (!blank) {
      return fail("found " + found() + " in the tag <" + brief(name),
                  "put a space before each attribute, and close the tag with > or />");
    }
    if (attributes.size() >= 100)
      return fail("the element has more than 100 attributes", "no element of a descriptor needs that many");
    if (!scan_attribute(attributes) || !count_part()) return false;
  }
}

bool Scanner::scan_end_tag() {
  advance(2);
  const std::string_view name = take_name();
  if (open_.empty()) {
    return fail("</" + brief(name) + "> closes nothing",
                "remove it, or open <" + brief(name) + "> before it");
  }
  if (name != open_.back().name) {
    const std::string expected = brief(open_.back().name);
    return fail("</" + brief(name) + "> does not close <" + expected + "> of line " +
                    std::to_string(open_.back().line),
                "close that element with </" + expected + "> first");
  }
  skip_blanks();
  if (!next_is(">")) return fail("found " + found() + " in </" + brief(name), "end the closing tag with >");
  advance(1);
  open_.pop_back();
  return true;
}

}  // namespace

std::optional<SyntaxError> find_syntax_error(std::string_view xml, std::vector<Span>* models) {
  if (std::optional<SyntaxError> error = find_bad_byte(xml)) return error;
  return Scanner{xml, models}.run();
}

}  // namespace takt::descriptor
