// A canvas that produces SVG. The canvas cannot measure text, so it assumes the letter width of the widest
// monospaced font. The drawing grows with its content.
#pragma once

#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace takt::tool {

// All sizes are in pixels. `kLetter` is the assumed width of a letter, as a share of the font size. In common
// monospaced fonts the width is 0.55 to 0.61.
inline constexpr double kLetter = 0.63;
inline constexpr double kSmall = 10;
inline constexpr double kNormal = 12;
inline constexpr double kLarge = 14;
inline constexpr double kMargin = 20;

/// The maximum width of a text in this font size, in pixels.
double width_of(std::string_view text, double size);

/// Escapes a text for use as XML text or as an XML attribute.
std::string escaped(std::string_view text);

struct Point {
  double x = 0;
  double y = 0;
};

/// Collects the elements of a drawing, and determines its size.
class Canvas {
 public:
  void text(double x, double y, double size, std::string_view classes, std::string_view text);
  void centred(double x, double y, double size, std::string_view classes, std::string_view text);
  /// Writes a text whose right end is at `x`.
  void text_before(double x, double y, double size, std::string_view classes, std::string_view text);
  void rectangle(double x, double y, double width, double height, std::string_view classes,
                 double radius = 0);
  void line(double x1, double y1, double x2, double y2, std::string_view classes);
  void diamond(double x, double y, double size, std::string_view classes);
  /// Draws a line through at least two points. A closed path returns to the first point.
  void path(const std::vector<Point>& points, std::string_view classes, bool closed = false);
  void circle(double x, double y, double radius, std::string_view classes);
  void open_group(std::string_view title) { append("<g><title>{}</title>", escaped(title)); }
  void open_group(std::string_view title, std::string_view classes) {
    append(R"(<g class="{}"><title>{}</title>)", classes, escaped(title));
  }
  /// Opens a group that has the attribute data-NAME="VALUE", by which a web page finds the group in the
  /// drawing.
  void open_group(std::string_view title, std::string_view classes, std::string_view name,
                  std::string_view value) {
    append(R"(<g class="{}" data-{}="{}"><title>{}</title>)", classes, name, escaped(value), escaped(title));
  }
  void close_group() { append("</g>"); }

  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }

  /// The whole drawing as an SVG document that follows the viewer's light or dark theme. `colours` is
  /// additional CSS, which `dark_colours` overrides in the dark theme. The document defines the CSS classes
  /// title, faint, on, page, panel, odd, grid, lane, thread and process.
  [[nodiscard]] std::string document(std::string_view title, std::string_view colours,
                                     std::string_view dark_colours) const;
  /// The drawing as an SVG element for an HTML page, whose styles must contain page_colours().
  [[nodiscard]] std::string figure(std::string_view title) const;

 private:
  template <class... Arguments>
  void append(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(body_), format, std::forward<Arguments>(arguments)...);
    body_ += '\n';
  }
  void put(double x, double y, double size, std::string_view classes, std::string_view anchor,
           std::string_view text);
  void reach(double x, double y);

  std::string body_;
  double width_ = 0;
  double height_ = 0;
};

/// The CSS that document() uses: the CSS of the light theme with `colours`, and the CSS of the dark theme
/// with `dark_colours`.
std::string page_colours(std::string_view colours, std::string_view dark_colours);

}  // namespace takt::tool
