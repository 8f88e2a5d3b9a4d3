// What a benchmark but Table 1 has measured: tables of numbers, each row beside what it is to be compared
// with, and sentences on what follows from them.
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
  std::vector<double> values;  ///< one for each column; NaN: there is none
};

struct Section {
  std::string title;
  std::vector<std::string> columns;  ///< with the unit: "p50 us"
  std::vector<Row> rows{};
  std::vector<std::string> notes{};  ///< a sentence each
};

struct Report {
  std::string benchmark;
  os::Platform machine{};
  std::int64_t wall_ns = 0;  ///< when it began
  Nanoseconds stolen{};      ///< from all processors meanwhile, by other machines
  std::string load{};        ///< what ran beside it; empty: nothing of ours
  Problems refused{};        ///< what the system refused; it was measured without
  std::vector<Section> sections{};
};

/// Those of `more` that are not in `all` yet.
void add_once(Problems& all, const Problems& more);

/// The columns of a distribution of times, and its values there.
std::vector<std::string> time_columns();
std::vector<double> in_columns(const Distribution& d);

/// Numbers with as many digits as matter; "-" for none.
std::string report_text(const Report& report);
/// A value that is none is null. A column "p50 us" is the key "p50_us".
nlohmann::ordered_json report_json(const Report& report);

}  // namespace takt::bench
