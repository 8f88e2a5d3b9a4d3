// DDS alone: a writer in one process, a reader in another, with the type and quality of service of a
// connection and nothing of Takt before and after.
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

/// From write() to the reader's listener, ns, one for each sample that came. Not where there are other
/// threads.
Result<std::vector<std::int64_t>> run_bare_dds(const BareDds& settings);

/// What the writer's process does; the exit status. It is told its settings by its environment.
int serve_as_writer();

}  // namespace takt::bench
