// Chooses the identity with which a program connects to the nodes of a secured cell.
#pragma once

#include <string>

#include <takt/core/result.hpp>
#include <takt/dds/participant.hpp>

#include <takt/client/network.hpp>

namespace takt::client {

/// Returns the identity folder with which the program connects to nodes: the folder that `network` names. If
/// `takt secure init` created that folder, returns the folder of the first valid operator in it, and prints
/// why earlier operators were skipped. Returns "" if `network` does not enable DDS Security.
Result<std::string> identity_of(const Network& network);

/// Fails if the identity of the participant has expired: then nodes no longer accept it.
Result<void> check_identity(const dds::Participant& participant);

/// Checks that the program may write samples. Fails if the participant has the identity of an observer. The
/// problem then states that an observer may not do `what`, for example "call". Call this function before you
/// create a writer, because DDS would reject the writer without a helpful reason.
Result<void> may_write(const dds::Participant& participant, const std::string& what);

}  // namespace takt::client
