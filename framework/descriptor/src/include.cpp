#include "include.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <takt/core/words.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/validate.hpp>
#include "element.hpp"

namespace takt::descriptor {

namespace {

/// Returns true if the element may contain an <include>. In other elements, an <include> is reported as an
/// unknown element.
bool may_include(const Node& parent) {
  return parent.name == "cell" || parent.name == "root" || parent.name == "device" ||
         parent.name == "fragment";
}

template <class T>
void move_all(std::vector<T>& from, std::vector<T>& to) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

}  // namespace

std::string path_beside(const std::string& from, const std::string& file) {
  return (std::filesystem::path{from}.parent_path() / file).lexically_normal().string();
}

void Includes::put_into(Node& root, const std::string& file, std::size_t bytes) {
  bytes_ = bytes;
  std::vector<std::string> chain{std::filesystem::path{file}.lexically_normal().string()};
  put_into(root, chain);
}

void Includes::put_into(Node& parent, std::vector<std::string>& chain) {
  if (!may_include(parent)) return;
  const bool any = std::any_of(parent.children.begin(), parent.children.end(), [](const Node& child) {
    return child.name == "include" || may_include(child);
  });
  if (!any) return;
  std::vector<Node> children = std::move(parent.children);
  parent.children.clear();
  for (Node& child : children) {
    if (child.name == "include") {
      if (report_.full() || put_in(child, parent, chain)) continue;
      parent.incomplete = true;
      incomplete_ = true;
    } else {
      put_into(child, chain);
      parent.children.push_back(std::move(child));
    }
  }
}

const std::string* Includes::text_of(const Node& include, const std::string& path) {
  auto known = texts_.find(path);
  if (known == texts_.end()) {
    auto text = read_(path);
    if (!text) {
      for (const Problem& problem : text.problems())
        report_.add(include.line, "the included file " + in_quotes(path) + " " + problem.what, problem.fix);
      return nullptr;
    }
    known = texts_.emplace(path, std::move(*text)).first;
  }
  bytes_ += known->second.size();
  if (bytes_ <= kMaxBytes) return &known->second;
  report_.add(include.line,
              "with " + in_quotes(path) + ", the descriptor and the files that it includes are larger than " +
                  std::to_string(kMaxBytes >> 20U) + " MiB",
              "a descriptor is far smaller: are these the right files?");
  return nullptr;
}

/// Inserts the content of the included file into `parent`. On failure, reports the problem and returns false.
bool Includes::put_in(const Node& include, Node& parent, std::vector<std::string>& chain) {
  const Element element{include, {.attributes = {"file"}}, report_};
  const auto file = element.required_attribute("file");
  if (!file) return false;
  const auto reject = [&](std::string what, std::string fix) {
    report_.add(file->line, std::move(what), std::move(fix));
    return false;
  };
  const std::string name = file->trimmed();
  if (name.empty())
    return reject(file->what + " is empty", "write the path of a file, relative to this file");
  if (name.size() > model::kMaxFilename)
    return reject("the path " + in_quotes(name) + " is too long", "at most 4096 bytes are allowed");
  const std::string path = path_beside(chain.back(), name);
  const auto circle = std::find(chain.begin(), chain.end(), path);
  if (circle != chain.end()) {
    std::string files;
    for (auto each = circle; each != chain.end(); ++each) files += brief(*each) + ", which includes ";
    return reject(in_quotes(path) + " includes itself: " + files + "it again",
                  "move what both files need into a third file");
  }
  if (chain.size() > kMaxIncludeDepth) {
    return reject("includes are nested more than " + std::to_string(kMaxIncludeDepth) + " levels deep",
                  "include " + in_quotes(path) + " directly in the descriptor");
  }
  if (++includes_ > kMaxIncludes) {
    if (includes_ > kMaxIncludes + 1) return false;  // this problem was already reported
    return reject("more than " + std::to_string(kMaxIncludes) + " files are included",
                  "merge several of them into one");
  }
  const std::string* text = text_of(include, path);
  if (text == nullptr) return false;

  insertions_.push_back({path, include.line, false});
  const auto insertion = static_cast<std::uint32_t>(insertions_.size());
  Node fragment;
  if (const auto fault = read_tree(*text, insertion, fragment)) {
    report_.add({fault->line, insertion}, fault->what, fault->fix);
    return false;
  }
  if (fragment.name != "fragment") {
    report_.add(fragment.line, "an included file has the root element <" + brief(fragment.name) + ">",
                "use <fragment> as its root element");
    return false;
  }
  // Check only the attributes of the <fragment> here. Its children are checked later, against the shape of
  // the element that includes the file.
  Node without_children = fragment;
  without_children.children.clear();
  const Element held{without_children, {.text = true}, report_};
  chain.push_back(path);
  put_into(fragment, chain);
  chain.pop_back();
  move_all(fragment.children, parent.children);
  move_all(fragment.texts, parent.texts);
  parent.incomplete = parent.incomplete || fragment.incomplete;
  return true;
}

}  // namespace takt::descriptor
