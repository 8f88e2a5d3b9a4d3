// Forwards the requests and commands of web pages to devices. Each call waits for the device, usually at most
// a few seconds; if a component is slow to stop or to start, the call waits longer.
#pragma once

#include <memory>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/model/cell.hpp>

#include "web/answer.hpp"

namespace takt::tool::web {

/// Forwards requests to devices. Any thread may call the functions. A request's body is untrusted input from
/// a browser; if the body is invalid, the answer says so.
class DeviceRequests {
 public:
  /// `sender` must outlive this object.
  explicit DeviceRequests(client::Operator& sender) noexcept : sender_(sender) {}

  Answer command(const std::string& body);
  Answer acknowledge(const std::string& body);
  Answer set_property(const std::string& body);
  /// `running`, here and in table(), is the running cell, or null if none is known.
  Answer properties(const std::string& module);
  Answer ports(const std::string& device);
  Answer table(const std::string& device, const std::shared_ptr<const model::Cell>& running);

 private:
  Answer described(const std::string& device, Json& modules);

  client::Operator& sender_;
};

}  // namespace takt::tool::web
