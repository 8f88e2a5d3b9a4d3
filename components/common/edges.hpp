// Rising edges of a flag. For real-time threads.
#pragma once

#include <cstdint>

namespace common {

/// R_TRIG of IEC 61131-3: the flag is taken to have been false before its first value.
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

/// Reads all that has come to a port of flags; how many rising edges there were among it. The port's value is
/// the newest then.
template <class Port>
std::uint32_t count_rising(Port& port, RisingEdge& edge) noexcept {
  std::uint32_t edges = 0;
  while (port.read()) edges += edge.step(port.value().value()) ? 1 : 0;
  return edges;
}

/// Goes on to the newest sample of a port, whatever kind its connection is. False when none has come since.
template <class Port>
bool read_newest(Port& port) noexcept {
  bool any = false;
  while (port.read()) any = true;
  return any;
}

}  // namespace common
