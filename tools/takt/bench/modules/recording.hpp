// What a bench module has measured: one entry a release, kept in memory that is there before the first one,
// and written to a file when everything is over. So measuring costs the real-time path one store, and a
// module that is not asked to record nothing at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace takt::bench {

/// One release that was served. Lies in the file as it does in memory: it is read on the same machine.
struct Served {
  std::int64_t number = 0;  ///< its place in the module's grid; a missed one leaves a gap
  std::int64_t value = 0;   ///< ns; what it means is said by who records it
};

class Recording {
 public:
  /// Allocates and touches the memory. What comes after `most` entries is not kept.
  void reserve(std::size_t most) { entries_.resize(most); }
  /// Real-time.
  void note(std::int64_t number, std::int64_t value) noexcept {
    if (count_ < entries_.size()) entries_[count_++] = {number, value};
  }
  /// False when the file cannot be written.
  [[nodiscard]] bool write(const std::string& path) const {
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return false;
    const bool whole = std::fwrite(entries_.data(), sizeof(Served), count_, file) == count_;
    return std::fclose(file) == 0 && whole;
  }
  /// What was written; empty when there is no such file.
  static std::vector<Served> read(const std::string& path) {
    std::vector<Served> entries;
    std::FILE* const file = std::fopen(path.c_str(), "rb");
    if (file == nullptr) return entries;
    Served entry;
    while (std::fread(&entry, sizeof entry, 1, file) == 1) entries.push_back(entry);
    std::fclose(file);
    return entries;
  }

 private:
  std::vector<Served> entries_;
  std::size_t count_ = 0;
};

}  // namespace takt::bench
