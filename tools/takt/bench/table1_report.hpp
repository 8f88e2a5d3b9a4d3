// What `takt bench table1` says: for a person, as it goes; and for a program. The page is table1_page.hpp.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "table1_result.hpp"

namespace takt::bench {

/// What stands above the rows.
std::string table1_head(const Table1Result& result);
/// The rows of a case: Takt's numbers, the paper's, the bare loop's.
std::string table1_rows(const CaseResult& one, const Table1Result& result);
/// What the columns mean.
std::string table1_foot();

/// Everything but the single samples.
nlohmann::ordered_json table1_json(const Table1Result& result);

}  // namespace takt::bench
