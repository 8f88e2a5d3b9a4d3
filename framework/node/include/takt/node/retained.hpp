// Writes what modules with <retain> save to disk, so that it survives a restart of the machine.
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

/// One module's file: FOLDER/CELL.DEVICE.MODULE.saved
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

/// Writes changed states at regular intervals and at its end. It uses a thread of its own, because a disk may
/// be slow. Not for real-time threads.
class Retained {
 public:
  struct One {
    SavedFile file;
    channel::SavedState* state;  ///< must outlive the Retained
    std::uint64_t written = 0;   ///< number of the saved state that is on disk
    bool failed = false;         ///< a write failed, which was reported
  };
  /// Calls `report` on that thread when a file cannot be written, once, and when it can be written again.
  static Result<std::unique_ptr<Retained>> start(std::vector<One> all,
                                                 std::function<void(const std::string&)> report,
                                                 Nanoseconds every = std::chrono::seconds{1});
  ~Retained();
  /// Does not wait: true once the last states are on disk. After that the destructor does not block.
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
