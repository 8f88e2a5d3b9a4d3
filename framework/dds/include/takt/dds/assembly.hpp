// Data that is longer than one sample, from the parts in which it comes. Whoever sends them may be anybody,
// so what is never finished takes a bounded room.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace takt::dds {

/// Of one sample, as idl/takt.idl has it.
inline constexpr std::size_t kPart = 32768;
/// Of a whole command or reply.
inline constexpr std::size_t kMaxData = 16 * 1024 * 1024;

/// Parts of one key come from one writer in order. What is not finished makes room for what comes, the oldest
/// first. Head is the type of a part, Whole has `head` and `data`.
template <class Head, class Whole>
class Assembly {
 public:
  /// As many keys, and bytes, of which parts are missing are kept.
  static constexpr std::size_t kUnfinished = 64;
  static constexpr std::size_t kMostBytes = 4 * kMaxData;

  /// The whole, once its last part has come. False for a part that makes no sense, or that others are missing
  /// before.
  bool add(const Head& part, const std::string& key, Whole& whole) {
    const std::size_t parts = part.parts();
    const bool last = part.part() + 1 == parts;
    if (parts == 0 || parts > kMaxData / kPart || (!last && part.data().size() != kPart) ||
        part.data().size() > kPart) {
      ++refused_;
      return false;
    }
    const std::string_view data{reinterpret_cast<const char*>(part.data().data()), part.data().size()};
    if (parts == 1) {
      whole.head = part;
      whole.data = data;
      return true;
    }
    if (part.part() == 0) {
      forget(unfinished_.find(key));
      if (unfinished_.size() == kUnfinished) forget(oldest());
      unfinished_[key].begun = ++begun_;
    }
    while (bytes_ + data.size() > kMostBytes) forget(oldest());
    const auto found = unfinished_.find(key);
    if (found == unfinished_.end() || found->second.next != part.part()) return false;
    found->second.data += data;
    bytes_ += data.size();
    if (++found->second.next < parts) return false;
    whole.head = part;
    whole.data = std::move(found->second.data);
    bytes_ -= whole.data.size();
    unfinished_.erase(found);
    return true;
  }
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }
  /// Of what is not finished.
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  struct Unfinished {
    std::uint64_t begun = 0;
    std::uint32_t next = 0;  // part that is to come
    std::string data;
  };
  using All = std::map<std::string, Unfinished>;

  void forget(typename All::iterator one) {
    if (one == unfinished_.end()) return;
    bytes_ -= one->second.data.size();
    unfinished_.erase(one);
  }
  typename All::iterator oldest() {
    return std::min_element(unfinished_.begin(), unfinished_.end(),
                            [](const auto& a, const auto& b) { return a.second.begun < b.second.begun; });
  }

  All unfinished_;
  std::size_t bytes_ = 0;
  std::uint64_t begun_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace takt::dds
