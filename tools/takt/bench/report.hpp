// The report of a benchmark other than Table 1: tables of numbers, with the references as rows, and notes.
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
  std::vector<double> values;  ///< one for each column; NaN: no value
};

struct Section {
  std::string title;
  std::vector<std::string> columns;  ///< with the unit: "p50 us"
  std::vector<Row> rows{};
  std::vector<std::string> notes{};  ///< one sentence each
};

struct Report {
  std::string benchmark;
  os::Platform machine{};
  std::int64_t wall_ns = 0;  ///< begin of the benchmark
  Nanoseconds stolen{};      ///< CPU time, of all CPUs, that other virtual machines took meanwhile
  std::string load{};        ///< the load started by the benchmark; empty: none
  Problems refused{};        ///< requests that the system denied; the benchmark ran without them
  std::vector<Section> sections{};
};

/// Adds the problems of `more` that are not in `all` yet.
void add_once(Problems& all, const Problems& more);

/// The columns for a distribution of times, and the values for them.
std::vector<std::string> time_columns();
std::vector<double> in_columns(const Distribution& d);

/// Numbers have three significant digits; "-" for no value.
std::string report_text(const Report& report);
/// A missing value becomes null. The column "p50 us" has the key "p50_us".
nlohmann::ordered_json report_json(const Report& report);

}  // namespace takt::bench
