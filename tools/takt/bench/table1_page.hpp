// Table 1 and Figures 12 to 19 of the paper as an HTML page, with the measurements of this machine beside the
// paper's. The page is self-contained: no network, no script.
#pragma once

#include <string>

#include "table1_result.hpp"

namespace takt::bench {

std::string table1_page(const Table1Result& result);

}  // namespace takt::bench
