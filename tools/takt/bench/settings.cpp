#include "settings.hpp"

#include <takt/os/trial.hpp>

namespace takt::bench {

int cpu_of(const Settings& settings) { return settings.cpu.value_or(os::executor_cpus().back()); }

}  // namespace takt::bench
