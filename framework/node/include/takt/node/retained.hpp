// What modules with <retain> save, on disk, for when the machine was switched off.
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
  /// What is in it becomes what the module saved. Nothing happens where there is none. Fails on a file that
  /// cannot be read or is damaged; nothing is saved then.
  Result<void> read_into(channel::SavedState& state) const;
  Result<void> remove() const;

 private:
  std::string path_;
};

/// Writes what has changed now and then, on a thread of its own, because a disk may take its time; and at its
/// end. Not for real-time threads.
class Retained {
 public:
  struct One {
    SavedFile file;
    channel::SavedState* state;  ///< outlives this
    std::uint64_t written = 0;   ///< the number that is on disk
    bool refused = false;        ///< it was said that it cannot be written
  };
  /// `said` is called, on that thread, with what could not be written, once, and when it could be again.
  static Result<std::unique_ptr<Retained>> start(std::vector<One> all,
                                                 std::function<void(const std::string&)> said,
                                                 Nanoseconds every = std::chrono::seconds{1});
  ~Retained();
  /// Does not wait: true once the last is on disk; then the end takes no time.
  [[nodiscard]] bool finish();

 private:
  Retained(std::vector<One> all, std::function<void(const std::string&)> said)
      : all_(std::move(all)), said_(std::move(said)) {}
  void write_changes();

  std::vector<One> all_;
  std::function<void(const std::string&)> said_;
  std::atomic<std::uint32_t> end_{0};
  std::atomic<bool> finished_{false};
  os::Thread thread_;
};

}  // namespace takt::node
