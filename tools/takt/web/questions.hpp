// Forwards questions and commands of pages to devices. Each call waits for the device: usually at most a few
// seconds, longer if a component takes long to stop or to start.
#pragma once

#include <memory>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/model/cell.hpp>

#include "web/said.hpp"

namespace takt::tool::web {

/// An HTTP status, and JSON as the body.
struct Answer {
  int status = 200;
  std::string body;
};
Answer answer_of(const Json& json);
/// {"what", "fix"}; `problem.where` is put in front of "what".
Answer answer_of(int status, const Problem& problem);

/// Any thread may call its functions. The body of a request is untrusted input from a browser; an invalid
/// body gets an answer, too.
class Questions {
 public:
  /// `asker` outlives this object.
  explicit Questions(client::Operator& asker) noexcept : asker_(asker) {}

  Answer command(const std::string& body);
  Answer set_property(const std::string& body);
  /// `running`, here and below: the running cell; null if none is known.
  Answer properties(const std::string& module, const std::shared_ptr<const model::Cell>& running);
  Answer ports(const std::string& device);
  Answer table(const std::string& device, const std::shared_ptr<const model::Cell>& running);

 private:
  Answer described(const std::string& device, Json& description);

  client::Operator& asker_;
};

}  // namespace takt::tool::web
