#include <takt/client/user.hpp>

#include <takt/core/words.hpp>
#include <takt/os/environment.hpp>
#include <takt/wire/words.hpp>

namespace takt::client {

std::string user_at_machine() { return wire::cut(on_one_line(os::user_name() + "@" + os::host_name()), 255); }

}  // namespace takt::client
