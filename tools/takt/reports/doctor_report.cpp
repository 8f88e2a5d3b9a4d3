#include "reports/doctor_report.hpp"

#include <fmt/format.h>

#include "reports/page.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& finding, const char* key) { return finding[key].get<std::string>(); }

void add_bad(Page& page, const Json& finding, const std::string& mark) {
  constexpr std::size_t kIndent = 10;
  page.line(0, fmt::format("  {}  {}", mark, page.bold(text_of(finding, "check"))));
  page.sentence(kIndent, text_of(finding, "found"));
  page.sentence(kIndent, "why:  " + text_of(finding, "why"));
  const std::string cure = text_of(finding, "cure");
  if (cure.empty()) return;
  const std::string elsewhere = text_of(finding, "mend_on");
  page.line(
      kIndent,
      "cure: " + (elsewhere.empty() ? "" : "not possible on this machine; on " + elsewhere + ": ") + cure);
}

}  // namespace

std::string doctor_text(const Json& report, Style style) {
  Page page{style};
  const auto spoils = report["spoils"].get<std::size_t>();
  const auto notes = report["notes"].get<std::size_t>();
  page.heading(0, "machine " + report["machine"].get<std::string>(),
               (spoils == 0 ? std::string{"nothing found that spoils real-time behaviour"}
                            : fmt::format("{} real-time behaviour",
                                          spoils == 1 ? "1 finding spoils"
                                                      : fmt::format("{} findings spoil", spoils))) +
                   (notes == 0 ? "" : ", " + count(notes, "note")));
  for (const Json& finding : report["findings"]) {
    if (finding["severity"] == "spoils") add_bad(page, finding, page.warning("spoils"));
  }
  for (const Json& finding : report["findings"]) {
    if (finding["severity"] == "note") add_bad(page, finding, "note  ");
  }
  for (const Json& finding : report["findings"]) {
    if (finding["severity"] == "good")
      page.sentence(2, fmt::format("good    {}: {}", text_of(finding, "check"), text_of(finding, "found")));
  }
  if (!report["root"].get<bool>())
    page.sentence(2, "takt doctor did not run as root. Findings that need root say so.");
  return std::move(page).take();
}

}  // namespace takt::tool
