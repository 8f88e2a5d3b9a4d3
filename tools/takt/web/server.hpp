// The gateway by HTTP. cpp-httplib is named in its source and nowhere else.
#pragma once

#include <memory>
#include <string>

#include <takt/core/result.hpp>

namespace takt::tool::web {

class Gateway;

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< to listen on
  int port = 8080;                    ///< 0: one that is free
  std::string token{};                ///< who has it may command; empty: nobody may
};

/// Serves from threads of its own until it is gone.
class Server {
 public:
  /// The gateway outlives it. Fails where the address is not this machine's, or the port is taken.
  static Result<std::unique_ptr<Server>> create(Gateway& gateway, const ServerOptions& options);
  virtual ~Server() = default;
  [[nodiscard]] virtual int port() const noexcept = 0;

 protected:
  Server() = default;
};

/// Whether a page may have been asked for under this name (the header Host, with a port or without): an
/// address, localhost or this machine's name. Another name may be somebody's who made it lead here, so that
/// his page could read ours.
bool is_own_name(const std::string& host, const std::string& machine);

}  // namespace takt::tool::web
