// Assembles data from parts. The sender splits data that is too long for one sample. Anyone on the network
// may send parts, so the memory for incomplete data is limited.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include <takt/wire/takt.h>

namespace takt::wire {

/// The largest number of data bytes in one sample, as in idl/takt.idl. A sample fits into two IP packets of
/// 1280 bytes, so that one lost packet costs only this sample.
inline constexpr std::size_t kPart = 1024;
/// The largest number of data bytes in a whole command or reply.
inline constexpr std::size_t kMaxData = 16 * 1024 * 1024;

/// A command with the data of all its parts, up to kMaxData bytes.
struct WholeCommand {
  Command head;  ///< the fields `part`, `parts` and `data` are not used
  std::string data;
  std::string who{};  ///< the authenticated sender, for people; empty in a cell without DDS Security
};
struct WholeReply {
  Reply head;
  std::string data;
};

/// Assembles data for several keys at the same time. The parts of one key come from one writer, in order. If
/// a new part would exceed a limit, the oldest incomplete data is dropped. `Head` is the type of a part;
/// `Whole` is a struct with the members `head` and `data`.
template <class Head, class Whole>
class Assembly {
 public:
  /// The limits for incomplete data: the number of keys, and the number of bytes over all keys.
  static constexpr std::size_t kUnfinished = 64;
  static constexpr std::size_t kMostBytes = 4 * kMaxData;

  /// Adds a part. Returns true and sets `whole` if this was the last part. Returns false if later parts are
  /// still missing, if this part is invalid, or if an earlier part was lost.
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
  /// The number of bytes of incomplete data, over all keys.
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  struct Unfinished {
    std::uint64_t begun = 0;
    std::uint32_t next = 0;  // number of the part that must come next
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

}  // namespace takt::wire
