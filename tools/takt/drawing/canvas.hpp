// Draws SVG. The width of text cannot be measured here, so every text gets room for the widest letters of a
// monospaced font. The drawing is as large as its content.
#pragma once

#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace takt::tool {

// All sizes are in pixels. The width of a letter in the monospaced fonts in use is 0.55 to 0.61 of its size.
inline constexpr double kLetter = 0.63;
inline constexpr double kSmall = 10;
inline constexpr double kNormal = 12;
inline constexpr double kLarge = 14;
inline constexpr double kMargin = 20;

/// The maximum width of a text, in pixels.
double width_of(std::string_view text, double size);

/// The text, escaped for XML texts and attributes.
std::string escaped(std::string_view text);

struct Point {
  double x = 0;
  double y = 0;
};

/// Collects the elements of a drawing and its extent.
class Canvas {
 public:
  void text(double x, double y, double size, std::string_view classes, std::string_view text);
  void centred(double x, double y, double size, std::string_view classes, std::string_view text);
  /// Text that ends at x.
  void text_before(double x, double y, double size, std::string_view classes, std::string_view text);
  void rectangle(double x, double y, double width, double height, std::string_view classes,
                 double radius = 0);
  void line(double x1, double y1, double x2, double y2, std::string_view classes);
  void diamond(double x, double y, double size, std::string_view classes);
  /// A line through at least two points; a closed path returns to the first point.
  void path(const std::vector<Point>& points, std::string_view classes, bool closed = false);
  void circle(double x, double y, double radius, std::string_view classes);
  void open_group(std::string_view title) { append("<g><title>{}</title>", escaped(title)); }
  void open_group(std::string_view title, std::string_view classes) {
    append(R"(<g class="{}"><title>{}</title>)", classes, escaped(title));
  }
  /// Like the function above, but with an attribute data-NAME, by which a page that contains the drawing
  /// finds the group.
  void open_group(std::string_view title, std::string_view classes, std::string_view name,
                  std::string_view value) {
    append(R"(<g class="{}" data-{}="{}"><title>{}</title>)", classes, name, escaped(value), escaped(title));
  }
  void close_group() { append("</g>"); }

  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }

  /// The whole drawing as an SVG document that follows the light or dark theme of its surroundings. `colours`
  /// is additional CSS, which `dark_colours` overrides in the dark theme. The classes svg, text, title,
  /// faint, on, page, panel, odd, grid, lane, thread and process are defined.
  [[nodiscard]] std::string document(std::string_view title, std::string_view colours,
                                     std::string_view dark_colours) const;
  /// The drawing for an HTML page, whose styles must contain page_colours().
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

/// The CSS of document() for the light and the dark theme, followed by `colours` and `dark_colours`.
std::string page_colours(std::string_view colours, std::string_view dark_colours);

}  // namespace takt::tool
