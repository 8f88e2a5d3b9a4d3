// The reference DDS alone: a writer in one process and a reader in another, with the type and the quality of
// service of a connection, but without Takt.
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

/// Runs the writer and the reader. Returns the time from write() to the listener of the reader in ns, for
/// each sample that arrived. Call it only while the process has no other threads.
Result<std::vector<std::int64_t>> run_bare_dds(const BareDds& settings);

/// The main function of the writer's process. Gets its settings from the environment. Returns the exit
/// status.
int serve_as_writer();

}  // namespace takt::bench
