// Names the user of a client.
#pragma once

#include <string>

namespace takt::client {

/// Returns the name of the user who runs this program, for nodes that know it from no identity, such as
/// "anna@panel-pc". At most 255 bytes.
std::string user_at_machine();

}  // namespace takt::client
