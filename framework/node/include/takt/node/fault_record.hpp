// The fault record of a device: the last few thousand events, in a file that outlives the node, however the
// node ends.
//
// The file consists of slots of fixed size, with one event in each slot. The file has its full size from the
// beginning. When it is full, a new event replaces an old one. A module may log many lines, so lines that
// modules log and all other events both keep at least half of the slots, if they need them. The node writes
// an event, with a number and a checksum, by one write of one slot. If the node dies during this write, the
// slot is invalid; readers skip and count it. The numbers continue when the node starts again, so that a
// missing event is visible. The node also keeps the events in memory. If writing the file fails, the node
// continues with the record in memory only. A disk may take long to answer, so a separate thread waits for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/agent/memory.hpp>
#include <takt/core/result.hpp>
#include <takt/model/fault.hpp>
#include <takt/node/worker.hpp>
#include <takt/os/fixed_file.hpp>

namespace takt::node {

/// The content of a fault record, as read from its file.
struct Recorded {
  std::vector<model::Fault> events;  ///< in the order of their numbers
  std::uint64_t overwritten = 0;     ///< number of older events whose slots newer events have reused
  std::uint64_t damaged = 0;         ///< number of slots that do not hold a valid event, or hold one whose
                                     ///< number another slot has too
};

/// The size of a slot, in bytes.
inline constexpr std::size_t kSlotBytes = 1024;
/// Encodes an event as the bytes of a slot. Cuts off texts that are too long.
std::string encode_slot(const model::Fault& fault);
/// Decodes the bytes of a slot. Returns nothing if the slot was never written, is incomplete, or is damaged.
std::optional<model::Fault> decode_slot(std::string_view slot);

/// Reads a fault record from the content of its file. Fails if it is not a fault record of this version.
Result<Recorded> read_record(std::string_view content);
/// Reads a fault record from the file with this path.
Result<Recorded> read_record_file(const std::string& path);

class FaultRecord final : public agent::FaultMemory {
 public:
  static constexpr std::size_t kSlots = 4096;
  /// Returns the path of a device's fault record, FOLDER/DEVICE.DOMAIN.faults.
  static std::string path(const std::string& folder, const std::string& device, int domain);

  /// Creates an empty record in memory only.
  explicit FaultRecord(std::size_t slots = kSlots);
  /// Opens the record in this file and continues it, or creates the file. Renames a file that is not a record
  /// of this version to PATH.damaged. Always returns a record. problems() states why the record is only in
  /// memory, or which file was renamed.
  static FaultRecord open(const std::string& path, std::size_t slots = kSlots);

  /// Gives the event the next number, and adds it to the record in memory and to the file. Does not wait for
  /// the disk.
  void append(model::Fault& fault) override;
  /// If the file could not be opened or written, begins to open it again. Returns true if an earlier call has
  /// opened it; then the file is in use and contains all events that are in memory. If another event in the
  /// file already has the number of an event in memory, the event in memory gets a new number. Does not wait
  /// for the disk.
  bool reopen() override;
  void keep(std::vector<std::uint64_t> numbers) override { kept_ = std::move(numbers); }
  void sync() const override;
  /// Begins to store the appended events on the disk, unless a call before is still doing this. Does not wait
  /// for the disk.
  void begin_sync();
  [[nodiscard]] const std::vector<model::Fault>& events() const noexcept override { return recorded_.events; }
  [[nodiscard]] std::uint64_t overwritten() const noexcept override { return recorded_.overwritten; }
  [[nodiscard]] std::uint64_t damaged() const noexcept override { return recorded_.damaged; }
  [[nodiscard]] const Problems& problems() const noexcept override { return problems_; }
  [[nodiscard]] const std::string& file() const noexcept override { return path_; }

 private:
  Result<void> attach(const std::string& path);
  void begin_to_open();
  /// Starts the worker if necessary. Returns false if the system denies a thread.
  bool has_worker();
  [[nodiscard]] std::size_t replaced_by(const model::Fault& fault) const;

  std::size_t slots_;
  std::uint64_t next_ = 1;
  Recorded recorded_;
  std::vector<std::size_t> places_;  // the slot of each event
  std::vector<std::uint64_t> kept_;  // the numbers of events that are not replaced
  std::vector<std::size_t> free_;    // the slots without an event; the last one is used first
  std::shared_ptr<os::FixedFile> file_;
  std::string path_;
  std::string wanted_;  // the path given to open(); empty for a record that was created in memory only
  Problems problems_;
  std::future<std::unique_ptr<FaultRecord>> opening_;  // the record in the file that reopen() is opening
  std::unique_ptr<Worker> worker_;                     // null until it is needed
};

}  // namespace takt::node
