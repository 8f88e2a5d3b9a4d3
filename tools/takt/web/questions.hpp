// Forwards the requests and commands of web pages to devices. Each call waits for the device, usually at most
// a few seconds. It waits longer if a component is slow to stop or to start.
#pragma once

#include <memory>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/model/cell.hpp>

#include "web/said.hpp"

namespace takt::tool::web {

/// An HTTP response: its status, and its body as JSON.
struct Answer {
  int status = 200;
  std::string body;
};
Answer answer_of(const Json& json);
/// An answer with the body {"what", "fix"}. If the problem has a `where`, "what" begins with it.
Answer answer_of(int status, const Problem& problem);

/// Any thread may call its functions. A request's body is untrusted input from a browser; if it is invalid,
/// the answer says so.
class Questions {
 public:
  /// `asker` must outlive this object.
  explicit Questions(client::Operator& asker) noexcept : asker_(asker) {}

  Answer command(const std::string& body);
  Answer set_property(const std::string& body);
  /// `running`, here and in table(), is the running cell, or null if none is known.
  Answer properties(const std::string& module, const std::shared_ptr<const model::Cell>& running);
  Answer ports(const std::string& device);
  Answer table(const std::string& device, const std::shared_ptr<const model::Cell>& running);

 private:
  Answer described(const std::string& device, Json& description);

  client::Operator& asker_;
};

}  // namespace takt::tool::web
