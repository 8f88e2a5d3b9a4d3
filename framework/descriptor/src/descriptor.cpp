#include <takt/descriptor/descriptor.hpp>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>
#include "bundle.hpp"
#include "expand.hpp"
#include "include.hpp"
#include "read_cell.hpp"
#include "tree.hpp"
#include "write.hpp"

namespace takt::descriptor {

namespace {

/// The result of reading a valid descriptor.
struct Read {
  model::Cell cell;
  Node tree;  ///< the descriptor with its includes and templates expanded
  std::map<std::string, std::string> included;
};

Problem too_large(const std::string& file) {
  return {location(file, 1), "the file is larger than " + std::to_string(kMaxBytes >> 20U) + " MiB",
          "a descriptor is far smaller: is this the right file?"};
}

Result<Read> read(Node tree, std::size_t bytes, const std::string& file, const ReadFile& read_file,
                  model::Cell* rejected = nullptr) {
  std::vector<model::Insertion> insertions;
  Report report{{file, insertions}};
  Includes includes{insertions, read_file, report};
  includes.put_into(tree, file, bytes);
  Expansion{file, insertions, includes.incomplete(), report}.expand(tree);

  Reading reading = read_cell(tree, file, report);
  reading.cell.insertions = insertions;
  model::Findings findings{reading.cell};
  model::validate(reading.cell, reading.gaps, findings);
  report.add(findings);
  if (!report.empty()) {
    if (rejected != nullptr) *rejected = std::move(reading.cell);
    return report.take();
  }
  model::connect_services(reading.cell);
  return Read{std::move(reading.cell), std::move(tree), includes.texts()};
}

Result<Node> tree_of(std::string_view xml, const std::string& file) {
  if (xml.size() > kMaxBytes) return too_large(file);
  Node tree;
  if (const auto error = read_tree(xml, 0, tree))
    return Problem{location(file, error->line), error->what, error->fix};
  return tree;
}

Result<Read> read_bundle(const Node& bundle, const std::string& file) {
  const std::vector<model::Insertion> none;
  Report report{{file, none}};
  const std::vector<Source> sources = sources_of(bundle, report);
  if (sources.empty()) return report.take();
  const Source& descriptor = sources.front();
  auto tree = tree_of(descriptor.text, descriptor.file);
  if (!tree) return tree.problems();
  auto all = read(std::move(*tree), descriptor.text.size(), descriptor.file,
                  [&sources](const std::string& path) -> Result<std::string> {
                    for (const Source& source : sources) {
                      if (source.file == path) return source.text;
                    }
                    return fail("was not sent with the descriptor", "send a bundle, as takt deploy does");
                  });
  if (!all) return all;
  for (std::size_t i = 1; i < sources.size(); ++i) {
    if (all->included.count(sources[i].file) == 0)
      report.add(sources[i].line, "no file includes the source " + in_quotes(sources[i].file),
                 "remove it from the bundle");
  }
  if (!report.empty()) return report.take();
  return all;
}

/// Returns the content of a file. Of a file that is too large, returns the first kMaxBytes + 1 bytes, so that
/// the caller can reject the file.
Result<std::string> content_of(const std::string& file) {
  errno = 0;
  std::ifstream stream{file, std::ios::binary};
  std::string content(kMaxBytes + 1, '\0');
  if (stream) stream.read(content.data(), static_cast<std::streamsize>(content.size()));
  const int error = errno;
  // Check the result of reading, too, because a directory can be opened but not read.
  if (!stream.is_open() || stream.bad() || (stream.gcount() == 0 && error != 0))
    return fail("cannot be read" + (error != 0 ? ": " + std::generic_category().message(error) : ""));
  content.resize(static_cast<std::size_t>(stream.gcount()));
  return content;
}

/// Returns the content of an included file, from the file system.
Result<std::string> included_content(const std::string& path) {
  std::error_code error;
  // Reject anything but a regular file, because opening a pipe, for example, may block forever.
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
    return fail("is not a regular file", "include a regular file");
  auto content = content_of(path);
  if (content) return content;
  return fail(content.problems()[0].what, "a path is relative to the file that includes it");
}

Result<Read> read_file(const std::string& file, std::string* text, model::Cell* rejected = nullptr) {
  auto content = content_of(file);
  if (!content)
    return Problem{on_one_line(file), "the file " + content.problems()[0].what,
                   "give the path of a descriptor"};
  auto tree = tree_of(*content, file);
  if (!tree) return tree.problems();
  if (tree->name == "bundle") {
    if (text != nullptr) *text = *content;
    return read_bundle(*tree, file);
  }
  auto all = read(std::move(*tree), content->size(), file, included_content, rejected);
  if (!all || text == nullptr) return all;
  *text = std::move(*content);
  if (all->included.empty()) return all;
  std::vector<Source> sources{{file, std::move(*text)}};
  for (auto& [path, included] : all->included) sources.push_back({path, included});
  *text = bundle_of(sources);
  if (text->size() > kMaxBytes) return too_large(file);
  return all;
}

}  // namespace

Result<model::Cell> parse(std::string_view xml, const std::string& file) {
  auto tree = tree_of(xml, file);
  if (!tree) return tree.problems();
  auto all = tree->name == "bundle"
                 ? read_bundle(*tree, file)
                 : read(std::move(*tree), xml.size(), file, [](const std::string&) -> Result<std::string> {
                     return fail("was not sent with the descriptor", "send a bundle, as takt deploy does");
                   });
  if (!all) return all.problems();
  return std::move(all->cell);
}

Result<model::Cell> load(const std::string& file, std::string* text, model::Cell* rejected) {
  auto all = read_file(file, text, rejected);
  if (!all) return all.problems();
  return std::move(all->cell);
}

Result<std::string> flatten(const std::string& file) {
  auto all = read_file(file, nullptr);
  if (!all) return all.problems();
  return written(all->tree, all->cell.texts());
}

}  // namespace takt::descriptor
