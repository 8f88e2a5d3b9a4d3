// What is shown in place of the list: one module or device, the connections, the keys.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "watch/line.hpp"
#include "watch/seen.hpp"
#include "watch/view.hpp"

namespace takt::tool::watch {

/// Of "DEVICE" or "DEVICE.MODULE"; says so where it is there no more.
std::vector<Line> details_page(const Seen& seen, const std::string& target, std::size_t columns,
                               ScreenStyle style);

/// Those that the filter takes, what is wrong first.
std::vector<Line> connections_page(const Seen& seen, const std::string& filter, std::size_t columns,
                                   ScreenStyle style);

std::vector<Line> help_page(ScreenStyle style);

}  // namespace takt::tool::watch
