// Formats the output of `takt bench table1` as text (one case at a time) or as JSON. table1_page.hpp makes the
// HTML page.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "table1_result.hpp"

namespace takt::bench {

/// The head of the text: the machine, the title and the names of the columns.
std::string table1_head(const Table1Result& result);
/// The rows of one case: the numbers for Takt, for the paper and for the bare loop.
std::string table1_rows(const CaseResult& one, const Table1Result& result);
/// The foot of the text, which explains the columns.
std::string table1_foot();

/// All results as JSON, without the individual samples.
nlohmann::ordered_json table1_json(const Table1Result& result);

}  // namespace takt::bench
