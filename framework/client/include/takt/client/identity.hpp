// The identity with which a command takes part in a secured cell.
#pragma once

#include <string>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>

#include <takt/client/network.hpp>

namespace takt::client {

/// The folder of an identity that may query nodes: the folder that `network` names, or, in a folder that
/// `takt secure init` made, the first valid operator's. Prints the operators that it skips. Empty: no DDS
/// Security.
Result<std::string> identity_of(const Network& network);

/// Fails for the identity of an observer, which may not do `what` ("call"). Checked early, because DDS would
/// deny the topic without a helpful reason.
Result<void> may_write(const dds::Participant& participant, const std::string& what);

}  // namespace takt::client
