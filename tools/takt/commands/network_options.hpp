// The options that say where on the network a program is.
#pragma once

#include <CLI/CLI.hpp>

#include <takt/client/network.hpp>

namespace takt::tool {

inline void add_network_options(CLI::App& app, client::Network& network) {
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

}  // namespace takt::tool
