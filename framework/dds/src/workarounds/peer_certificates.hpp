// Shows the certificate of each participant that has authenticated. Only the source files of this room
// include this header.
//
// Fast DDS 2.9.1 checks a certificate only during the authentication, and gives no access to it afterwards
// (CVE-2025-67108).
#pragma once

#include <functional>

#include "../fast_dds.hpp"

struct x509_st;

namespace takt::dds {

/// Lets `seen` look at the certificate of each participant that has just authenticated, before Fast DDS
/// exchanges keys with it. Threads of Fast DDS call `seen`, until it is replaced by an empty function. Ends
/// the process if the function of Fast DDS that peer_certificates.cpp replaces is missing.
void look_at_certificates(
    std::function<void(const rtps::GuidPrefix_t& peer, const x509_st& certificate)> seen);

}  // namespace takt::dds
