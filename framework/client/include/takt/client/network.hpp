// A program's network settings, from its command-line options and environment variables.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

struct Network {
  std::optional<int> domain;
  std::string peers;       ///< the value of --peers, such as "10.0.0.1,10.0.0.2"; may be empty
  std::string server;      ///< the value of --server, such as "10.0.0.1:11811"; may be empty
  std::string security{};  ///< a folder; if empty, security_of() uses TAKT_SECURITY
  /// Called with a line of text that says for what a command waits longer than usual. It may be empty.
  std::function<void(const std::string&)> progress{};
};

/// Returns the parts of a text between commas. Ignores empty parts.
std::vector<std::string> split(const std::string& text);

/// Returns the DDS domain: network.domain (--domain) if it is set, otherwise the value of TAKT_DOMAIN,
/// otherwise the cell's domain, otherwise 0. Fails if network.domain is not set and TAKT_DOMAIN is not a
/// valid domain.
Result<int> domain_of(const Network& network, const model::Cell* cell = nullptr);
/// Returns a note for the user if TAKT_DOMAIN replaces a domain that the cell's descriptor names; otherwise
/// an empty text.
std::string domain_note(const Network& network, const model::Cell& cell);
/// Returns the discovery settings: those of --peers or --server if given, otherwise those of the cell.
model::Discovery discovery_of(const Network& network, const model::Cell* cell = nullptr);
/// Returns the options that make another program use the same domain and discovery, for advice to the user,
/// for example "--domain 0 --server 10.0.0.1:11811".
std::string options_of(int domain, const model::Discovery& discovery);
/// Returns the value of --security if given, otherwise the value of TAKT_SECURITY: an identity folder, or a
/// folder that `takt secure init` created. Empty if DDS Security is off.
std::string security_of(const Network& network);
/// Returns the IPv4 addresses of the network interfaces to use, from TAKT_INTERFACE; empty for all
/// interfaces.
std::vector<std::string> interfaces();

}  // namespace takt::client
