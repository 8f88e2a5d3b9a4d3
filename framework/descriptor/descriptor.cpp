#include <takt/descriptor/descriptor.hpp>

#include <cerrno>
#include <fstream>
#include <system_error>

#include <tinyxml2.h>

#include <takt/core/words.hpp>
#include <takt/descriptor/read_cell.hpp>
#include <takt/descriptor/well_formed.hpp>
#include <takt/model/validate.hpp>

namespace takt::descriptor {

namespace {

Problem too_large(const std::string& file) {
  return {place(file, 1), "the file is larger than " + std::to_string(kMaxBytes >> 20U) + " MiB",
          "a descriptor is far smaller: is this the right file?"};
}

}  // namespace

Result<model::Cell> parse(std::string_view xml, const std::string& file) {
  if (xml.size() > kMaxBytes) return too_large(file);
  if (const auto fault = find_fault(xml)) return Problem{place(file, fault->line), fault->what, fault->fix};

  tinyxml2::XMLDocument document;
  document.Parse(xml.data(), xml.size());
  const tinyxml2::XMLElement* root = document.RootElement();
  if (document.Error() || root == nullptr) {
    return Problem{place(file, document.ErrorLineNum()),
                   std::string{"the XML cannot be read ("} + document.ErrorName() + ")",
                   "check the tags, quotes and entities of this line"};
  }

  Report report{file};
  Reading reading = read_cell(*root, file, report);
  report.add(model::validate(reading.cell, reading.gaps));
  if (!report.empty()) return report.take();
  model::connect_services(reading.cell);
  return std::move(reading.cell);
}

Result<model::Cell> load(const std::string& file, std::string* text) {
  errno = 0;
  std::ifstream stream{file, std::ios::binary};
  std::string content(kMaxBytes + 1, '\0');
  if (stream) stream.read(content.data(), static_cast<std::streamsize>(content.size()));
  const int error = errno;
  // A directory opens and cannot be read.
  if (!stream.is_open() || stream.bad() || (stream.gcount() == 0 && error != 0)) {
    const std::string reason = error != 0 ? ": " + std::generic_category().message(error) : "";
    return Problem{on_one_line(file), "the file cannot be read" + reason, "give the path of a descriptor"};
  }
  content.resize(static_cast<std::size_t>(stream.gcount()));
  if (text != nullptr) *text = content;
  return parse(content, file);
}

}  // namespace takt::descriptor
