// Where on the network a program of Takt is: the options that all of them have.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::tool {

struct Network {
  std::optional<int> domain;
  std::string peers;       ///< "10.0.0.1,10.0.0.2"
  std::string server;      ///< "10.0.0.1:11811"
  std::string security{};  ///< a folder; empty: as TAKT_SECURITY says
};

inline void add_network_options(CLI::App& app, Network& network) {
  app.add_option("--domain", network.domain,
                 "the DDS domain, 0 to 232 (else TAKT_DOMAIN, else the descriptor's, else 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 232).description(""));
  auto* peers =
      app.add_option("--peers", network.peers, "find each other by these addresses, not by multicast")
          ->type_name("A,B,...");
  app.add_option("--server", network.server, "find each other by a discovery server")
      ->type_name("HOST:PORT")
      ->excludes(peers);
  app.add_option(
         "--security", network.security,
         "who this is in a secured cell: a folder of takt secure (else TAKT_SECURITY, else nobody, and "
         "nothing is encrypted)")
      ->type_name("FOLDER");
}

/// --domain, else TAKT_DOMAIN, else what the cell says, else 0. Fails on a TAKT_DOMAIN that is none.
Result<int> domain_of(const Network& network, const model::Cell* cell = nullptr);
/// --peers or --server, else as the cell says.
model::Discovery discovery_of(const Network& network, const model::Cell* cell = nullptr);
/// --security, else TAKT_SECURITY: the folder of this participant, or one that takt secure init made; empty:
/// without DDS Security.
std::string security_of(const Network& network);
/// TAKT_INTERFACE: the IPv4 addresses of the only interfaces to use; empty: all.
std::vector<std::string> interfaces();

}  // namespace takt::tool
