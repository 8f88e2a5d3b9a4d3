// What `takt watch` shows in a terminal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "style.hpp"

namespace takt::tool {

/// A device, or a module of the device above it.
struct WatchRow {
  std::string device;
  std::string module;  ///< empty: the row of the device
  std::string state;   ///< "EXECUTING"; of a device "running"
  bool lost = false;   ///< the node is not there any more; the rest is what was heard last
  std::string text;    ///< why it is not as it should be
  bool measured = false;
  std::uint64_t cycles = 0;
  double jitter_p50_us = 0;
  double jitter_p99_us = 0;
  std::uint64_t overruns = 0;
  std::uint64_t errors = 0;

  [[nodiscard]] std::string target() const { return module.empty() ? device : device + "." + module; }
};

struct WatchScreen {
  std::size_t selected = 0;  ///< a row
  std::string message;       ///< the answer to the last key
  std::deque<std::string> events;
};

/// The whole screen: exactly `lines` lines of at most `columns` columns, each begun by an escape that clears
/// it. The selected row is always among those that are shown. States are words; colour comes on
/// top where `style` has it.
std::string watch_screen(const std::vector<WatchRow>& rows, const WatchScreen& screen, std::size_t columns,
                         std::size_t lines, Style style);

/// "12:34:56.789" in local time.
std::string clock_text(std::int64_t wall_ns);

}  // namespace takt::tool
