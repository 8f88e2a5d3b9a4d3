#include "write.hpp"

#include <algorithm>

#include <takt/core/control_character.hpp>
#include <takt/core/words.hpp>

namespace takt::descriptor {

namespace {

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

class Writer {
 public:
  explicit Writer(const model::Texts& texts) : texts_(texts) {}

  void write(const Node& node, std::uint32_t within, std::size_t depth) {
    const std::string margin(2 * depth, ' ');
    if (node.line.insertion != within) {
      // A comment must not contain "--", so write "- -" instead.
      std::string from = location(texts_, node.line);
      if (const std::string how = history(texts_, node.line); !how.empty()) from += ", " + how;
      text_ += margin + "<!-- " + replaced(from, "--", "- - ") + " -->\n";
    }
    text_ += margin + "<" + node.name;
    for (const Attribute& one : node.attributes) text_ += " " + one.name + "=\"" + value_of(one.value) + "\"";
    const std::string value = value_of(node.text());
    if (value.empty() && node.children.empty()) {
      text_ += "/>\n";
      return;
    }
    text_ += ">" + value;
    if (!node.children.empty()) {
      text_ += "\n";
      for (const Node& child : node.children) write(child, node.line.insertion, depth + 1);
      text_ += margin;
    }
    text_ += "</" + node.name + ">\n";
  }

  std::string take() { return std::move(text_); }

 private:
  static std::string value_of(const std::string& text) { return escaped(replaced(text, "${", "$${")); }

  model::Texts texts_;
  std::string text_ = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
};

}  // namespace

std::string escaped(std::string_view text) {
  // Write carriage returns as references, because a parser may convert them, and other control
  // characters, because they could control a terminal. Write a text of only white space
  // as references, because a parser would ignore it.
  const bool blank = text.find_first_not_of(" \t\r\n") == std::string_view::npos;
  std::string result;
  while (!text.empty()) {
    const std::string_view character = text.substr(0, std::max<std::size_t>(utf8_length(text), 1));
    text.remove_prefix(character.size());
    const char c = character[0];
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if ((is_control_character(character) && c != '\t' && c != '\n') || (blank && character.size() == 1))
      result += xml_reference(character);
    else
      result += character;
  }
  return result;
}

std::string written(const Node& root, const model::Texts& texts) {
  Writer writer{texts};
  writer.write(root, 0, 0);
  return writer.take();
}

}  // namespace takt::descriptor
