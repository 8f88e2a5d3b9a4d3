// The HTTP server of `takt web`, which serves the page and the gateway's data. Only server.cpp uses
// cpp-httplib.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::tool::web {

class Gateway;

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< the IP address on which the server listens
  int port = 8080;                    ///< 0 chooses any free port
  std::string token{};                ///< commands need this token; if it is empty, no commands are allowed
  std::vector<std::string> names{};   ///< further host names under which the page can be opened
};

/// Serves requests on its own threads until it is destroyed.
class Server {
 public:
  /// Starts a server. `gateway` must outlive it. Fails if the address does not belong to this machine, or if
  /// the port is in use.
  static Result<std::unique_ptr<Server>> create(Gateway& gateway, const ServerOptions& options);
  virtual ~Server() = default;
  [[nodiscard]] virtual int port() const noexcept = 0;

 protected:
  Server() = default;
};

/// True if the host of a request (header Host, with or without a port) is an IP address, localhost or one of
/// the names: that of this machine, or one that --host-name allows. The server rejects other names: an
/// attacker could point a DNS name to this machine, so that a web page of the attacker can read the cell (DNS
/// rebinding).
bool is_own_name(const std::string& host, const std::vector<std::string>& names);

}  // namespace takt::tool::web
