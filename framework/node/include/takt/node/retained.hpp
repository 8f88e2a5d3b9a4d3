// Writes the saved state of modules with <retain> to disk, so that the state survives a restart of the
// machine.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/channel/saved_state.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/real_time.hpp>

namespace takt::node {

/// The file with the saved state of one module, FOLDER/CELL.DEVICE.MODULE.saved.
class SavedFile {
 public:
  SavedFile(const std::string& folder, const std::string& cell, const std::string& device,
            const std::string& module);
  [[nodiscard]] const std::string& path() const noexcept { return path_; }

  Result<void> write(const channel::SavedState::Copy& saved) const;
  /// Copies the state in the file into `state`. Does nothing if there is no file. If the file is damaged or
  /// cannot be read, fails and leaves `state` unchanged.
  Result<void> read_into(channel::SavedState& state) const;
  Result<void> remove() const;

 private:
  std::string path_;
};

/// Writes the states that have changed to disk, at regular intervals and at the end. A separate thread writes
/// them, because a disk may be slow. Real-time threads must not call these functions.
class Retained {
 public:
  struct One {
    SavedFile file;
    channel::SavedState* state;  ///< the state that the module saves; must outlive the Retained
    std::uint64_t written = 0;   ///< the number of the state that is on disk; 0 if no state is on disk
  };
  /// Starts the thread. The thread calls `report` when a file cannot be written, and again when this file can
  /// be written again.
  static Result<std::unique_ptr<Retained>> start(std::vector<One> all,
                                                 std::function<void(const std::string&)> report,
                                                 Nanoseconds every = std::chrono::seconds{1});
  ~Retained();
  /// Asks the thread to end, without waiting. Call finish() repeatedly until it returns true. When it has
  /// returned true, the last states are on disk, and the destructor does not block.
  [[nodiscard]] bool finish();

  /// Asks the thread to write all changed states now. Does not wait.
  void update();
  /// Returns nothing until all states that existed at the last update() are written. Afterwards returns
  /// success, or a problem if the file of `state` could not be written.
  [[nodiscard]] std::optional<Result<void>> updated(const channel::SavedState& state) const;

 private:
  Retained(std::vector<One> all, std::function<void(const std::string&)> report)
      : all_(std::move(all)), failed_(all_.size()), report_(std::move(report)) {}
  void write_changes();

  std::vector<One> all_;
  std::vector<std::atomic<bool>> failed_;  // for each file, true if the last write failed and was reported
  std::function<void(const std::string&)> report_;
  std::atomic<std::uint32_t> asked_{0};  // number of requests to write now
  std::atomic<std::uint32_t> done_{0};   // the value of asked_ at the beginning of the thread's last complete
                                         // write
  std::atomic<bool> end_{false};
  std::atomic<bool> finished_{false};
  os::Thread thread_;
};

}  // namespace takt::node
