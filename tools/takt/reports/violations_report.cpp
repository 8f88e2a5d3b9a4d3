#include "reports/violations_report.hpp"

#include <fmt/format.h>

namespace takt::tool {

std::string violations_text(const nlohmann::ordered_json& status) {
  std::string text;
  bool checked = false;
  for (const auto& device : status["devices"]) {
    if (!device.contains("realtime_violations")) continue;
    checked = true;
    for (const auto& v : device["realtime_violations"]) {
      const auto of = [&v](const char* key) { return v[key].get<std::string>(); };
      const std::string name = v.contains("executor") ? "executor " + of("executor") : of("module");
      text += fmt::format(
          "  {}.{}{}: {}{}, {}\n", device["name"].get<std::string>(), name,
          of("hook").empty() ? "" : " " + of("hook"), of("kind"), of("what").empty() ? "" : " " + of("what"),
          v["count"] == 1 ? "once" : fmt::format("{} times", v["count"].get<std::uint64_t>()));
      for (const auto& call : v["backtrace"]) text += "      " + call.get<std::string>() + "\n";
    }
  }
  if (!checked) return "";
  return text.empty() ? "\nno real-time violations\n" : "\nreal-time violations:\n" + text;
}

}  // namespace takt::tool
