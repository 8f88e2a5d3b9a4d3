#include "table1_cases.hpp"

#include <fmt/format.h>

#include "drawing/canvas.hpp"

namespace takt::bench {

namespace {

using model::ModuleType;

struct Element {
  std::string name;
  const char* file;
  const char* type;
  const char* operation;
  std::string time;  ///< the <period> or <deadline> element of the module
  int priority;
  std::string property;
};

std::string text_of(const Element& element) {
  return fmt::format(
      "    <module><name>{}</name><filename>{}</filename><moduletype>{}</moduletype>\n"
      "      <operationtype>{}</operationtype>{}<priority>{}</priority>{}</module>\n",
      element.name, element.file, element.type, element.operation, element.time, element.priority,
      element.property);
}

}  // namespace

const std::array<Table1Case, 10> kTable1{{
    {1, 1, 0, 0, 0, 0, ModuleType::thread, {-0.027, 0.000839, 3.772}},
    {2, 15, 0, 0, 0, 0, ModuleType::thread, {0.127, 0.002037, 2.933}},
    {3, 5, 3, 0, 0, 0, ModuleType::thread, {-0.042, 0.001263, 2.793}},
    {4, 5, 3, 0, 0, 0, ModuleType::process, {-5.723, 19.480341, 11.598}},
    {5, 5, 3, 11, 0, 0, ModuleType::thread, {0.033, 0.001174, 0.716}},
    {6, 5, 3, 11, 0, 0, ModuleType::process, {-5.580, 19.624376, 11.614}},
    {7, 5, 3, 5, 6, 0, ModuleType::thread, {-0.105, 0.001633, 1.405}},
    {8, 5, 3, 5, 6, 0, ModuleType::process, {-5.991, 21.136330, 12.438}},
    {9, 5, 3, 5, 5, 8, ModuleType::thread, {0.007, 0.001424, 1.104}},
    {10, 5, 3, 5, 5, 8, ModuleType::process, {-5.519, 20.617964, 11.758}},
}};

std::string descriptor_of(const Table1Case& one, const Table1Settings& settings) {
  const std::string period = fmt::format("<period>{}</period>", settings.period.count());
  const std::string deadline = fmt::format("<deadline>{}</deadline>", 100 * settings.period.count());
  const std::string records =
      fmt::format(R"(<property><value name="file">{}</value><value name="releases">{}</value></property>)",
                  tool::escaped(settings.file), settings.releases);
  const bool measures_thread = one.measured == ModuleType::thread;

  std::string text = fmt::format(
      R"(<cell name="table1_{}">
  <device name="bench">
    <executor name="main" cpu="{}" priority="{}"/>
)",
      one.number, settings.cpu, settings.priority);
  int priority = 1;
  const auto periodic = [&](int count, bool thread) {
    const bool measured = thread == measures_thread;
    for (int i = 1; i <= count; ++i) {
      const bool records_it = measured && i == 1;
      text +=
          text_of({records_it ? "measured" : fmt::format("{}{}", thread ? "so" : "exe", i),
                   thread ? "bench_periodic.so" : "bench_periodic_process.exe", thread ? "thread" : "process",
                   "periodic", period, records_it ? 1 : ++priority, records_it ? records : ""});
    }
  };
  const auto others = [&](int count, const char* name, const char* file, const char* type,
                          const char* operation, const std::string& time) {
    for (int i = 1; i <= count; ++i)
      text += text_of({fmt::format("{}{}", name, i), file, type, operation, time, ++priority, ""});
  };
  periodic(one.so, true);
  periodic(one.exe, false);
  others(one.sporadic_so, "sporadic_so", "bench_sporadic.so", "thread", "sporadic", deadline);
  others(one.sporadic_exe, "sporadic_exe", "bench_sporadic_process.exe", "process", "sporadic", deadline);
  others(one.non_real, "non_real", "bench_background.exe", "process", "non-real", "");
  return text + "  </device>\n</cell>\n";
}

}  // namespace takt::bench
