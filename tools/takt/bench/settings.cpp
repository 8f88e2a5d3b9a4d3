#include "settings.hpp"

#include <takt/os/real_time.hpp>

namespace takt::bench {

int cpu_of(const Settings& settings) { return settings.cpu.value_or(os::allowed_cpus().back()); }

}  // namespace takt::bench
