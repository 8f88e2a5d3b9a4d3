// Reads the newest samples of some outputs, for the details of a module in `takt watch`.
#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <takt/client/connection.hpp>
#include <takt/core/time.hpp>

namespace takt::tool {

/// Asks the devices to publish the outputs, and repeats this, on a thread of its own, because an answer may
/// take seconds. Only one thread may use an object of this class.
class PortValues {
 public:
  /// `client` must outlive the object.
  explicit PortValues(const client::Connection& client);
  PortValues(const PortValues&) = delete;
  PortValues& operator=(const PortValues&) = delete;
  ~PortValues();

  /// Sets the outputs whose samples are read, each as "device.module.port". Returns at once.
  void want(const std::vector<std::string>& ports);
  /// Returns the newest sample of each output as a text in one line, with its age from 2 s on.
  [[nodiscard]] std::map<std::string, std::string> newest() const;

 private:
  struct Source;
  void ask();

  const client::Connection& client_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::vector<std::string> wanted_;
  std::map<std::string, std::shared_ptr<Source>> sources_;
  std::thread thread_;  // the last member, because it uses all others
};

}  // namespace takt::tool
