// What a page asks of a device, and its answer. Each waits for the device, at most a few seconds; of a
// component that takes long to stop or to begin, longer.
#pragma once

#include <memory>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/model/cell.hpp>

#include "web/said.hpp"

namespace takt::tool::web {

/// A status of HTTP, and JSON.
struct Answer {
  int status = 200;
  std::string body;
};
Answer answer_of(const Json& json);
/// {"what", "fix"}; what it is about stands before `what`.
Answer answer_of(int status, const Problem& problem);

/// Any thread. Bodies are what a browser sent: whatever they are, they are answered.
class Questions {
 public:
  /// The asker outlives it.
  explicit Questions(client::Operator& asker) noexcept : asker_(asker) {}

  Answer command(const std::string& body);
  Answer set_property(const std::string& body);
  /// `running`, here and below: null where nothing is known to run.
  Answer properties(const std::string& module, const std::shared_ptr<const model::Cell>& running);
  Answer ports(const std::string& device);
  Answer table(const std::string& device, const std::shared_ptr<const model::Cell>& running);

 private:
  Answer described(const std::string& device, Json& description);

  client::Operator& asker_;
};

}  // namespace takt::tool::web
