// The list of revoked identities in an identity folder.
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include <takt/core/result.hpp>

namespace takt::security {

/// The file may be replaced while the program runs, so the program calls update() again and again. Not
/// thread-safe.
class Revocations {
 public:
  /// `folder` is an identity folder.
  explicit Revocations(std::string folder) : folder_(std::move(folder)) {}

  /// Reads the list again if its file has changed. Keeps the earlier list if the new file is not a list that
  /// the authority has signed. Fails, once for each such file, if that is so in kTries successive calls: the
  /// file may be just being copied.
  Result<void> update();
  /// Returns true if the certificate with this serial number is revoked.
  [[nodiscard]] bool contains(const std::string& serial) const { return serials_.contains(serial); }

  static constexpr int kTries = 8;

 private:
  std::string folder_;
  std::filesystem::file_time_type read_{};  // the time of the file that was read
  std::filesystem::file_time_type bad_{};   // the time of the file that could not be read
  int tried_ = 0;
  std::set<std::string> serials_;
};

}  // namespace takt::security
