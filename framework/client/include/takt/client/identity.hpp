// Who a command is in a secured cell.
#pragma once

#include <string>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>

#include <takt/client/network.hpp>

namespace takt::client {

/// The folder of an identity that may ask nodes: that which was named, or of the first operator in one of
/// `takt secure init`, and whom it passes over is said. Empty: without DDS Security.
Result<std::string> identity_of(const Network& network);

/// Fails for an observer, who may not `what` ("call"): said before DDS refuses him a topic.
Result<void> may_write(const dds::Participant& participant, const std::string& what);

}  // namespace takt::client
