// The recording of a bench module: one entry per release, in memory that is allocated before the first
// release and written to a file at the end. So a recorded release costs one store on the real-time path, and
// a release that is not recorded costs nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace takt::bench {

/// One release that was served. The file has the memory layout, because it is read on the same machine.
struct Served {
  std::int64_t number = 0;  ///< its place in the module's grid; a missed release leaves a gap
  std::int64_t value = 0;   ///< ns; the recording module defines the meaning
};

class Recording {
 public:
  /// Allocates and touches the memory. Only the first `most` entries are kept.
  void reserve(std::size_t most) { entries_.resize(most); }
  /// Real-time.
  void note(std::int64_t number, std::int64_t value) noexcept {
    if (count_ < entries_.size()) entries_[count_++] = {number, value};
  }
  /// False if the file cannot be written.
  [[nodiscard]] bool write(const std::string& path) const {
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return false;
    const bool whole = std::fwrite(entries_.data(), sizeof(Served), count_, file) == count_;
    return std::fclose(file) == 0 && whole;
  }
  /// The entries of a file; empty if it does not exist.
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
