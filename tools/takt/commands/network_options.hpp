// The command line options for the network: domain, discovery and identity.
#pragma once

#include <cstdio>

#include <CLI/CLI.hpp>

#include <takt/client/network.hpp>
#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::tool {

inline void add_network_options(CLI::App& app, client::Network& network) {
  network.progress = [](const std::string& text) {
    std::fprintf(stderr, "%s ...\n", on_one_line(text).c_str());
  };
  app.add_option("--domain", network.domain,
                 "the DDS domain, 0 to 232 (default: TAKT_DOMAIN, else the descriptor's, else 0)")
      ->type_name("N")
      ->check(CLI::Range(0, 232).description(""));
  auto* peers =
      app.add_option("--peers", network.peers, "discover nodes at these addresses instead of by multicast")
          ->type_name("A,B,...")
          ->check(CLI::Validator(
              [](const std::string& given) -> std::string {
                const std::vector<std::string> addresses = client::split(given);
                for (const std::string& one : addresses) {
                  if (!model::is_valid_host(one))
                    return in_quotes(one) + " is not an IPv4 address or a host name without a port";
                }
                return addresses.empty() ? "it names no address; write it as in 10.0.0.1,10.0.0.2" : "";
              },
              ""));
  app.add_option("--server", network.server, "discover nodes through this discovery server")
      ->type_name("HOST:PORT")
      ->check(CLI::Validator(
          [](const std::string& given) -> std::string {
            return model::is_valid_server(given)
                       ? ""
                       : in_quotes(given) + " is not an address and a port, as in 10.0.0.1:11811";
          },
          ""))
      ->excludes(peers);
  app.add_option("--security", network.security,
                 "the folder of this program's identity in a secured cell, created by takt secure (default: "
                 "TAKT_SECURITY; without either, the network is not encrypted)")
      ->type_name("FOLDER");
}

}  // namespace takt::tool
