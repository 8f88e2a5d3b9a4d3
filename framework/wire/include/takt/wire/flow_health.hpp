// The state of one flow: the samples of one topic that a gateway moves to or from DDS.
#pragma once

#include <cstdint>
#include <string>

namespace takt::wire {

/// The counters of a flow, which `takt` shows to operators.
struct FlowHealth {
  std::uint32_t matched = 0;
  std::uint64_t samples = 0;  ///< samples that the gateway moved
  std::uint64_t lost = 0;     ///< samples that were lost, according to gaps in the writer's sequence numbers
  std::uint64_t refused = 0;  ///< samples rejected because their bytes do not fit the type
  /// Samples whose time stamp cannot be right, so their age is measured from their arrival.
  std::uint64_t untimed = 0;
  std::uint64_t failures = 0;  ///< writes that DDS rejected
  /// The QoS policy that keeps writer and reader from matching, such as "reliability"; empty if none does.
  std::string incompatible;
};

}  // namespace takt::wire
