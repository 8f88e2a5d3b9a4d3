// The state of one flow of samples over DDS.
#pragma once

#include <cstdint>
#include <string>

namespace takt::wire {

/// For operators.
struct FlowHealth {
  std::uint32_t matched = 0;
  std::uint64_t samples = 0;   ///< moved
  std::uint64_t lost = 0;      ///< according to DDS, or to gaps in the writer's numbers
  std::uint64_t refused = 0;   ///< samples that do not fit the type
  std::uint64_t failures = 0;  ///< writes that DDS rejected
  std::string incompatible;    ///< the QoS policy that prevented a match, such as "reliability"; empty: none
};

}  // namespace takt::wire
