// Makes an HTML page like Table 1 and Figures 12 to 19 of the paper, which compares the measurements of this
// machine with the paper's results. The page is self-contained: it needs no network and no script.
#pragma once

#include <string>

#include "table1_result.hpp"

namespace takt::bench {

std::string table1_page(const Table1Result& result);

}  // namespace takt::bench
