// The identity with which a command takes part in a secured cell.
#pragma once

#include <string>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>

#include <takt/client/network.hpp>

namespace takt::client {

/// Returns the folder of an identity that may send commands to nodes. This is the folder that `network`
/// names. If `takt secure init` made that folder, it is the folder of the first valid operator in it; the
/// operators that are skipped are printed. Empty if `network` asks for no DDS Security.
Result<std::string> identity_of(const Network& network);

/// Fails if the participant has the identity of an observer, which may not do `what`, for example "call".
/// This is checked early, because DDS would reject the topic without a helpful reason.
Result<void> may_write(const dds::Participant& participant, const std::string& what);

}  // namespace takt::client
