// Detects rising edges of a flag. Real-time threads may use everything here.
#pragma once

#include <cstdint>

namespace common {

/// Detects rising edges as R_TRIG of IEC 61131-3 does: the flag counts as false before its first value.
class RisingEdge {
 public:
  bool step(bool value) noexcept {
    const bool edge = value && !last_;
    last_ = value;
    return edge;
  }
  [[nodiscard]] bool last() const noexcept { return last_; }

 private:
  bool last_ = false;
};

/// Reads all new samples of a flag port and returns the number of rising edges in them. The port's value is
/// then the newest sample.
template <class Port>
std::uint32_t count_rising(Port& port, RisingEdge& edge) noexcept {
  std::uint32_t edges = 0;
  while (port.read()) edges += edge.step(port.value().value()) ? 1 : 0;
  return edges;
}

/// Advances a port to its newest sample, for any kind of connection. Returns false if there is no new sample.
template <class Port>
bool read_newest(Port& port) noexcept {
  bool any = false;
  while (port.read()) any = true;
  return any;
}

}  // namespace common
