// The pages of `takt watch` other than the list: the details of a module or device, the connections, and the
// help.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "watch/line.hpp"
#include "watch/seen.hpp"
#include "watch/view.hpp"

namespace takt::tool::watch {

/// The details of `target`, which is "DEVICE" or "DEVICE.MODULE". If the target no longer exists, the page
/// says so.
std::vector<Line> details_page(const Snapshot& snapshot, const std::string& target, std::size_t columns,
                               ScreenStyle style);

/// The connections that match the filter. Connections with a problem come first.
std::vector<Line> connections_page(const Snapshot& snapshot, const std::string& filter, std::size_t columns,
                                   ScreenStyle style);

std::vector<Line> help_page(ScreenStyle style);

}  // namespace takt::tool::watch
