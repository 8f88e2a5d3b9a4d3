// The command line options of the network: domain, discovery and identity.
#pragma once

#include <CLI/CLI.hpp>

#include <takt/client/network.hpp>

namespace takt::tool {

inline void add_network_options(CLI::App& app, client::Network& network) {
  app.add_option("--domain", network.domain,
                 "the DDS domain, 0 to 232 (default: TAKT_DOMAIN, else the descriptor's, else 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 232).description(""));
  auto* peers =
      app.add_option("--peers", network.peers, "discover nodes at these addresses, not by multicast")
          ->type_name("A,B,...");
  app.add_option("--server", network.server, "discover nodes through a discovery server")
      ->type_name("HOST:PORT")
      ->excludes(peers);
  app.add_option(
         "--security", network.security,
         "the folder of the identity to use in a secured cell, from takt secure (default: TAKT_SECURITY; "
         "without either, nothing is encrypted)")
      ->type_name("FOLDER");
}

}  // namespace takt::tool
