// Where on the network a program of Takt is: what its options and environment say.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

struct Network {
  std::optional<int> domain;
  std::string peers;       ///< "10.0.0.1,10.0.0.2"
  std::string server;      ///< "10.0.0.1:11811"
  std::string security{};  ///< a folder; empty: as TAKT_SECURITY says
};

/// --domain, else TAKT_DOMAIN, else what the cell says, else 0. Fails on a TAKT_DOMAIN that is none.
Result<int> domain_of(const Network& network, const model::Cell* cell = nullptr);
/// --peers or --server, else as the cell says.
model::Discovery discovery_of(const Network& network, const model::Cell* cell = nullptr);
/// --security, else TAKT_SECURITY: the folder of this participant, or one that takt secure init made; empty:
/// without DDS Security.
std::string security_of(const Network& network);
/// TAKT_INTERFACE: the IPv4 addresses of the only interfaces to use; empty: all.
std::vector<std::string> interfaces();

}  // namespace takt::client
