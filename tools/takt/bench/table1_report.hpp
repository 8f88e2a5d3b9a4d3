// The output of `takt bench table1` as text, case by case, and as JSON. For the page see table1_page.hpp.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "table1_result.hpp"

namespace takt::bench {

/// The lines above the rows.
std::string table1_head(const Table1Result& result);
/// The rows of a case: the numbers of Takt, of the paper and of the bare loop.
std::string table1_rows(const CaseResult& one, const Table1Result& result);
/// The explanation of the columns.
std::string table1_foot();

/// All results, without the single samples.
nlohmann::ordered_json table1_json(const Table1Result& result);

}  // namespace takt::bench
