// The reference "DDS alone": a writer in one process and a reader in another, without Takt. Both use the data
// type and the QoS of the connections that `takt bench cell` measures.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::bench {

struct BareDds {
  int domain = 0;
  Nanoseconds period{};
  Nanoseconds length{};
};

/// Runs the writer and the reader. Returns, for each sample that arrived, the time from write() to the call
/// of the reader's listener, in ns. Call this function only while the process has no other threads.
Result<std::vector<std::int64_t>> run_bare_dds(const BareDds& settings);

/// The main function of the writer's process. Reads the settings from the environment, and returns the exit
/// status.
int serve_as_writer();

}  // namespace takt::bench
