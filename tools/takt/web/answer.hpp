// The response of `takt web` to an HTTP request.
#pragma once

#include <string>

#include <takt/core/result.hpp>

#include "web/samples_json.hpp"

namespace takt::tool::web {

/// An HTTP response: its status, and its body as JSON.
struct Answer {
  int status = 200;
  std::string body;
};
Answer answer_of(const Json& json);
/// An answer with the body {"what", "fix"}. If the problem has a `where`, "what" begins with it.
Answer answer_of(int status, const Problem& problem);

}  // namespace takt::tool::web
