#include "reports/properties_report.hpp"

#include <fmt/format.h>

#include <takt/core/words.hpp>

#include "reports/page.hpp"

namespace takt::tool {

std::string properties_text(const nlohmann::ordered_json& properties, Style style) {
  std::vector<Page::Words> rows{{"property", "value", "unit", "range", "type"}};
  for (const auto& property : properties) {
    const auto member = [&property](const char* name) {
      const auto found = property.find(name);
      return found == property.end() || !found->is_string() ? std::string{}
                                                            : on_one_line(found->get<std::string>());
    };
    const bool known = property.contains("value") && property["value"].is_string();
    const std::string value = member("value");
    rows.push_back({member("name"),
                    !known          ? "not known"
                    : value.empty() ? "''"
                                    : value,
                    member("unit"), member("range"), member("type")});
  }
  if (rows.size() == 1) return "the component declares no properties\n";
  Page page{style};
  page.table(0, rows);
  return std::move(page).take();
}

}  // namespace takt::tool
