// Table 1 and Figures 12 to 19 of the paper as one page of HTML: what was measured here beside what the paper
// says. It needs nothing but itself: no network, no script.
#pragma once

#include <string>

#include "table1_result.hpp"

namespace takt::bench {

std::string table1_page(const Table1Result& result);

}  // namespace takt::bench
