// The values that a module measures in a benchmark, one per release. The memory is allocated before the first
// release, and its content is written to a file at the end. So recording a value in real-time code costs only
// one store to memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace takt::bench {

/// The entry of one release that was served. A file has the same layout as the memory, because it is read on
/// the same machine.
struct Served {
  std::int64_t number = 0;  ///< the number of the release in the module's grid; missed releases leave gaps
  std::int64_t value = 0;   ///< a time in ns; the module that records it defines its meaning
};

class Recording {
 public:
  /// Allocates memory for `most` entries, and writes to all of it, so that real-time code causes no page
  /// faults. Further entries are dropped.
  void reserve(std::size_t most) { entries_.resize(most); }
  /// Adds an entry. Real-time code may call this function.
  void note(std::int64_t number, std::int64_t value) noexcept {
    if (count_ < entries_.size()) entries_[count_++] = {number, value};
  }
  /// Writes all entries to a file. Returns false if the file cannot be written.
  [[nodiscard]] bool write(const std::string& path) const {
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) return false;
    const bool whole = std::fwrite(entries_.data(), sizeof(Served), count_, file) == count_;
    return std::fclose(file) == 0 && whole;
  }
  /// Reads the entries of a file. Returns no entries if the file does not exist.
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
