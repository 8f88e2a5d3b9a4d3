// The interface and the domain of the tests: loopback, and a domain that tests of another build tree most
// likely do not use.
#pragma once

#include <cstdlib>
#include <functional>
#include <string>

#include <takt/dds/participant.hpp>

namespace takt::dds_test {

inline int domain() {
  const char* given = std::getenv("TAKT_TEST_DOMAIN");
  return given != nullptr ? std::atoi(given)
                          : 150 + static_cast<int>(std::hash<std::string>{}(TAKT_BINARY_DIR) % 10);
}

inline dds::ParticipantOptions on_loopback(const std::string& name) {
  return {.name = name, .domain = domain(), .discovery = {}, .interfaces = {"127.0.0.1"}};
}

}  // namespace takt::dds_test
