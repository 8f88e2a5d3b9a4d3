#include "report.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "surroundings.hpp"

namespace takt::bench {

namespace {

using json = nlohmann::ordered_json;

std::string number_text(double value) {
  if (std::isnan(value)) return "-";
  if (value == std::floor(value) && std::abs(value) < 1e15) return fmt::format("{:.0f}", value);
  const double size = std::abs(value);
  return fmt::format("{:.{}f}", value, size < 10 ? 2 : size < 100 ? 1 : 0);
}

std::string section_text(const Section& section) {
  std::size_t name = 0;
  for (const Row& row : section.rows) name = std::max(name, row.name.size());
  std::string text = fmt::format("\n{}\n  {:<{}}", section.title, "", name);
  for (const std::string& column : section.columns) text += fmt::format(" {:>10}", column);
  text += '\n';
  for (const Row& row : section.rows) {
    text += fmt::format("  {:<{}}", row.name, name);
    for (std::size_t i = 0; i < row.values.size(); ++i)
      text += fmt::format(" {:>{}}", number_text(row.values[i]),
                          std::max<std::size_t>(10, section.columns[i].size()));
    text += '\n';
  }
  for (const std::string& note : section.notes) text += "  " + note + "\n";
  return text;
}

}  // namespace

void add_once(Problems& all, const Problems& more) {
  for (const Problem& problem : more) {
    if (std::find(all.begin(), all.end(), problem) == all.end()) all.push_back(problem);
  }
}

std::vector<std::string> time_columns() { return {"p50 us", "p90 us", "p99 us", "p99.9 us", "max us"}; }

std::vector<double> in_columns(const Distribution& d) {
  if (d.count == 0) return std::vector<double>(5, std::nan(""));
  return {d.p50 / 1e3, d.p90 / 1e3, d.p99 / 1e3, d.p999 / 1e3, d.max / 1e3};
}

std::string report_text(const Report& report) {
  std::string text = machine_text(report.machine);
  if (!report.load.empty()) text += fmt::format("{:<13} {}\n", "background", report.load);
  for (const Section& section : report.sections) text += section_text(section);
  text += fmt::format("\nCPU time taken by other virtual machines during the benchmark: {:.0f} ms\n",
                      static_cast<double>(report.stolen.count()) / 1e6);
  for (const Problem& problem : report.refused) text += "denied: " + in_words(Problems{problem}) + "\n";
  return text;
}

json report_json(const Report& report) {
  json sections = json::array();
  for (const Section& section : report.sections) {
    json rows = json::array();
    for (const Row& row : section.rows) {
      json entry{{"name", row.name}};
      for (std::size_t i = 0; i < row.values.size(); ++i) {
        std::string key = section.columns[i];
        std::replace(key.begin(), key.end(), ' ', '_');
        entry[key] = std::isnan(row.values[i]) ? json(nullptr) : json(row.values[i]);
      }
      rows.push_back(entry);
    }
    sections.push_back({{"title", section.title}, {"rows", rows}, {"notes", section.notes}});
  }
  json refused = json::array();
  for (const Problem& problem : report.refused) refused.push_back(in_words(Problems{problem}));
  return {{"benchmark", report.benchmark},
          {"date", date_text(report.wall_ns)},
          {"machine", machine_json(report.machine)},
          {"stolen_ms", static_cast<double>(report.stolen.count()) / 1e6},
          {"load", report.load},
          {"refused", refused},
          {"sections", sections}};
}

}  // namespace takt::bench
