// The pages of `takt watch` other than the list: one module or device, the connections, the help.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "watch/line.hpp"
#include "watch/seen.hpp"
#include "watch/view.hpp"

namespace takt::tool::watch {

/// The details of `target`, "DEVICE" or "DEVICE.MODULE", or a note that it no longer exists.
std::vector<Line> details_page(const Snapshot& snapshot, const std::string& target, std::size_t columns,
                               ScreenStyle style);

/// The connections that match the filter, those with a problem first.
std::vector<Line> connections_page(const Snapshot& snapshot, const std::string& filter, std::size_t columns,
                                   ScreenStyle style);

std::vector<Line> help_page(ScreenStyle style);

}  // namespace takt::tool::watch
