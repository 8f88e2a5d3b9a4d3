// Serves the gateway over HTTP. Only server.cpp uses cpp-httplib.
#pragma once

#include <memory>
#include <string>

#include <takt/core/result.hpp>

namespace takt::tool::web {

class Gateway;

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< to listen on
  int port = 8080;                    ///< 0: any free port
  std::string token{};                ///< allows commands; empty: commands are not allowed
};

/// Serves on its own threads until it is destroyed.
class Server {
 public:
  /// The gateway outlives the server. Fails if the address does not belong to this machine, or the port is in
  /// use.
  static Result<std::unique_ptr<Server>> create(Gateway& gateway, const ServerOptions& options);
  virtual ~Server() = default;
  [[nodiscard]] virtual int port() const noexcept = 0;

 protected:
  Server() = default;
};

/// Whether the host name of a request (header Host, with or without a port) is valid: an IP address,
/// localhost or the name of this machine. Other names are rejected, because the owner of a DNS name could
/// point it to this machine so that a foreign page can read ours (DNS rebinding).
bool is_own_name(const std::string& host, const std::string& machine);

}  // namespace takt::tool::web
