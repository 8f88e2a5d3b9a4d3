// The fault record of a device: its last few thousand events, in a file that outlives its node however that
// ends.
//
// The file is a ring of slots of fixed size, one event each, all there from the beginning. An event is one
// write of one slot, with its number and a checksum: whoever dies in the middle leaves one slot that is no
// event, which is skipped and counted. Numbers go on over restarts, so that a gap shows. The same events are
// in memory; where the file fails, they are there alone and the node goes on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/fault.hpp>
#include <takt/os/fixed_file.hpp>

namespace takt::node {

/// What a record holds.
struct Recorded {
  std::vector<model::Fault> events;  ///< in the order of their numbers
  std::uint64_t overwritten = 0;     ///< older events, which newer ones took the place of
  std::uint64_t damaged = 0;         ///< slots whose content is no event
};

/// An event as it lies in a slot; texts that are too long are cut off.
inline constexpr std::size_t kSlotBytes = 1024;
std::string encode_slot(const model::Fault& fault);
/// None where the bytes are no event: torn, damaged, or never written.
std::optional<model::Fault> decode_slot(std::string_view slot);

/// What the file of a record holds. Fails where it is none, or one of another version.
Result<Recorded> read_record(std::string_view content);
/// The same of a file by its path.
Result<Recorded> read_record_file(const std::string& path);

class FaultRecord {
 public:
  static constexpr std::size_t kSlots = 4096;
  /// "FOLDER/DEVICE.DOMAIN.faults"
  static std::string path(const std::string& folder, const std::string& device, int domain);

  /// In memory alone.
  explicit FaultRecord(std::size_t slots = kSlots);
  /// Goes on with the file, or makes it. What is no record of this version is set aside as PATH.damaged.
  /// Whatever fails, there is a record: problems() says why it is in memory alone, or what was set aside.
  static FaultRecord open(const std::string& path, std::size_t slots = kSlots);

  /// Gives it its number. Writes to the file's pages, which does not wait for the disk.
  void append(model::Fault& fault);
  /// Where open() or a write failed: tries the file again. True when it was taken up, with all that is in
  /// memory. Events get other numbers where the file has others of theirs.
  bool take_up_again();
  [[nodiscard]] const std::vector<model::Fault>& events() const noexcept { return recorded_.events; }
  [[nodiscard]] std::uint64_t overwritten() const noexcept { return recorded_.overwritten; }
  [[nodiscard]] std::uint64_t damaged() const noexcept { return recorded_.damaged; }
  [[nodiscard]] const Problems& problems() const noexcept { return problems_; }
  /// Empty: it is in memory alone.
  [[nodiscard]] const std::string& file() const noexcept { return path_; }
  /// For a thread that may wait for the disk, which has what was appended once this was synchronised; null:
  /// it is in memory alone.
  [[nodiscard]] std::shared_ptr<const os::FixedFile> disk() const noexcept { return file_; }

 private:
  Result<void> take_up(const std::string& path);

  std::size_t slots_;
  std::uint64_t next_ = 1;
  Recorded recorded_;
  std::shared_ptr<os::FixedFile> file_;
  std::string path_;
  std::string wanted_;  // what open() was given; empty: it was not opened
  Problems problems_;
};

}  // namespace takt::node
