// Writes the saved state of modules with <retain> to disk, so that it survives a restart of the machine.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <takt/channel/saved_state.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/real_time.hpp>

namespace takt::node {

/// The file of one module, FOLDER/CELL.DEVICE.MODULE.saved.
class SavedFile {
 public:
  SavedFile(const std::string& folder, const std::string& cell, const std::string& device,
            const std::string& module);
  [[nodiscard]] const std::string& path() const noexcept { return path_; }

  Result<void> write(const channel::SavedState::Place& saved) const;
  /// Loads the file into `state`; does nothing if there is no file. Fails if the file is damaged or cannot be
  /// read, and leaves `state` unchanged.
  Result<void> read_into(channel::SavedState& state) const;
  Result<void> remove() const;

 private:
  std::string path_;
};

/// Writes changed states at regular intervals and at the end. It uses its own thread, because a disk may be
/// slow. Real-time threads must not call it.
class Retained {
 public:
  struct One {
    SavedFile file;
    channel::SavedState* state;  ///< must outlive the Retained
    std::uint64_t written = 0;   ///< number of the saved state that is on disk
    bool failed = false;         ///< whether the last write failed and this was reported
  };
  /// Starts the thread. It calls `report` once when a file cannot be written, and once when the file can be
  /// written again.
  static Result<std::unique_ptr<Retained>> start(std::vector<One> all,
                                                 std::function<void(const std::string&)> report,
                                                 Nanoseconds every = std::chrono::seconds{1});
  ~Retained();
  /// Ends the thread, without waiting. Call this repeatedly until it returns true. Then the last states are
  /// on disk, and the destructor does not block.
  [[nodiscard]] bool finish();

 private:
  Retained(std::vector<One> all, std::function<void(const std::string&)> report)
      : all_(std::move(all)), report_(std::move(report)) {}
  void write_changes();

  std::vector<One> all_;
  std::function<void(const std::string&)> report_;
  std::atomic<std::uint32_t> end_{0};
  std::atomic<bool> finished_{false};
  os::Thread thread_;
};

}  // namespace takt::node
