#include "drawing/canvas.hpp"

#include <algorithm>
#include <cmath>

#include <takt/core/control_character.hpp>
#include <takt/core/words.hpp>

namespace takt::tool {

namespace {

constexpr std::string_view kCanvasColours = R"(
svg { background: #ffffff; }
text { font-family: ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; fill: #1f2933; }
.title { font-weight: bold; }
.faint { fill: #5c6773; }
.on { fill: #ffffff; }
.page { fill: #ffffff; }
.panel { fill: #f5f7f9; }
.odd { fill: #e9edf1; }
.grid { stroke: #c3ccd5; stroke-width: 1; }
.lane { stroke: #dde3e9; stroke-width: 1; }
.thread { fill: #1d5fa8; }
.process { fill: #8a4a00; }
)";

constexpr std::string_view kDarkCanvasColours = R"(
svg { background: #14181d; }
text { fill: #e4e9ee; }
.faint { fill: #9aa6b2; }
.on { fill: #0d1116; }
.page { fill: #14181d; }
.panel { fill: #1c2229; }
.odd { fill: #252c35; }
.grid { stroke: #3d4854; }
.lane { stroke: #2c343d; }
.thread { fill: #7db4f0; }
.process { fill: #f0b060; }
)";

}  // namespace

double width_of(std::string_view text, double size) {
  return static_cast<double>(text.size()) * size * kLetter;
}

std::string escaped(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    text.remove_prefix(character.size());
    switch (const char c = character[0]; c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        if (static_cast<unsigned char>(c) < 0x20)
          result += ' ';
        else
          result += length == 0 || is_control_character(character) ? xml_reference(character)
                                                                   : std::string{character};
    }
  }
  return result;
}

void Canvas::text(double x, double y, double size, std::string_view classes, std::string_view text) {
  put(x, y, size, classes, "start", text);
  reach(x + width_of(text, size), y);
}

void Canvas::centred(double x, double y, double size, std::string_view classes, std::string_view text) {
  put(x, y, size, classes, "middle", text);
  reach(x + width_of(text, size) / 2, y);
}

void Canvas::text_before(double x, double y, double size, std::string_view classes, std::string_view text) {
  put(x, y, size, classes, "end", text);
  reach(x, y);
}

void Canvas::rectangle(double x, double y, double width, double height, std::string_view classes,
                       double radius) {
  append(R"(<rect x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" rx="{:.0f}" class="{}"/>)", x, y,
         width, height, radius, classes);
  reach(x + width, y + height);
}

void Canvas::line(double x1, double y1, double x2, double y2, std::string_view classes) {
  append(R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" class="{}"/>)", x1, y1, x2, y2, classes);
  reach(std::max(x1, x2), std::max(y1, y2));
}

void Canvas::diamond(double x, double y, double size, std::string_view classes) {
  append(R"(<path d="M{:.1f} {:.1f}l{} {}l-{} {}l-{} -{}z" class="{}"/>)", x, y - size, size, size, size,
         size, size, size, classes);
  reach(x + size, y + size);
}

void Canvas::path(const std::vector<Point>& points, std::string_view classes, bool closed) {
  std::string way;
  for (const Point& point : points) {
    way += fmt::format("{}{:.1f} {:.1f}", way.empty() ? 'M' : 'L', point.x, point.y);
    reach(point.x, point.y);
  }
  append(R"(<path d="{}{}" class="{}"/>)", way, closed ? "z" : "", classes);
}

void Canvas::circle(double x, double y, double radius, std::string_view classes) {
  append(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{:.1f}" class="{}"/>)", x, y, radius, classes);
  reach(x + radius, y + radius);
}

std::string Canvas::document(std::string_view title, std::string_view colours,
                             std::string_view dark_colours) const {
  const double width = std::ceil(width_ + kMargin);
  const double height = std::ceil(height_ + kMargin);
  return fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" height="{1:.0f}" role="img">
<title>{2}</title>
<style>{3}</style>
<rect x="0" y="0" width="{0:.0f}" height="{1:.0f}" class="page"/>
{4}</svg>
)",
      width, height, escaped(title), page_colours(colours, dark_colours), body_);
}

std::string Canvas::figure(std::string_view title) const {
  return fmt::format(
      R"(<svg viewBox="0 0 {0:.0f} {1:.0f}" width="{0:.0f}" height="{1:.0f}" role="img">
<title>{2}</title>
{3}</svg>
)",
      std::ceil(width_ + kMargin), std::ceil(height_ + kMargin), escaped(title), body_);
}

std::string page_colours(std::string_view colours, std::string_view dark_colours) {
  return fmt::format("{}{}@media (prefers-color-scheme: dark) {{{}{}}}\n", kCanvasColours, colours,
                     kDarkCanvasColours, dark_colours);
}

void Canvas::put(double x, double y, double size, std::string_view classes, std::string_view anchor,
                 std::string_view text) {
  append(R"(<text x="{:.1f}" y="{:.1f}" font-size="{}" text-anchor="{}" class="{}">{}</text>)", x, y, size,
         anchor, classes, escaped(text));
}

void Canvas::reach(double x, double y) {
  width_ = std::max(width_, x);
  height_ = std::max(height_, y);
}

}  // namespace takt::tool
