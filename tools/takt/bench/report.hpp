// The report of a benchmark other than Table 1: tables of numbers, with one row for each variant and
// reference, and notes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/platform.hpp>

#include "distribution.hpp"

namespace takt::bench {

struct Row {
  std::string name;
  std::vector<double> values;  ///< one value for each column; NaN if there is no value
};

struct Section {
  std::string title;
  std::vector<std::string> columns;  ///< the titles of the columns, with the unit: "p50 us"
  std::vector<Row> rows{};
  std::vector<std::string> notes{};  ///< the lines of the notes below the table
};

struct Report {
  std::string benchmark;
  os::Platform machine{};
  std::int64_t wall_ns = 0;  ///< when the benchmark began
  Nanoseconds stolen{};      ///< CPU time, on all CPUs, that other virtual machines took during the benchmark
  std::string load{};        ///< the command line of the background load, or empty
  Problems refused{};        ///< requests that the system denied to the benchmark
  std::vector<Section> sections{};
};

/// Adds the problems of `more` that are not in `all` yet.
void add_once(Problems& all, const Problems& more);

/// The titles of the columns that show a distribution of times. in_columns() returns the values in these
/// columns.
std::vector<std::string> time_columns();
std::vector<double> in_columns(const Distribution& d);

/// The report as text. Numbers have three significant digits; "-" stands for a missing value.
std::string report_text(const Report& report);
/// The report as JSON. The column "p50 us" has the key "p50_us". A missing value is null.
nlohmann::ordered_json report_json(const Report& report);

}  // namespace takt::bench
