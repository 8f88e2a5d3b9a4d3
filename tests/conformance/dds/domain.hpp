// The network interface and the DDS domain that the tests use: loopback, and a domain number that depends on
// the build folder. So tests of two build folders rarely share a domain.
#pragma once

#include <cstdlib>
#include <functional>
#include <string>

#include <folders.hpp>
#include <takt/dds/participant.hpp>

namespace takt::dds_test {

inline int domain() {
  const char* given = std::getenv("TAKT_TEST_DOMAIN");
  return given != nullptr ? std::atoi(given)
                          : 150 + static_cast<int>(std::hash<std::string>{}(build_path("")) % 10);
}

inline dds::ParticipantOptions on_loopback(const std::string& name) {
  return {.name = name, .domain = domain(), .discovery = {}, .interfaces = {"127.0.0.1"}};
}

}  // namespace takt::dds_test
