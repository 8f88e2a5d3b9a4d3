#include <takt/node/log.hpp>

#include <chrono>
#include <cstdio>
#include <ctime>

#include <fmt/format.h>

#include <takt/core/words.hpp>

namespace takt::node {

namespace {
bool silent = false;
}

void log_nothing() { silent = true; }

void log(std::string_view device, std::string_view module, std::string_view text) {
  if (silent) return;
  const auto now = std::chrono::system_clock::now();
  const auto ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm local{};
  ::localtime_r(&seconds, &local);
  // Print the whole line with one write, so that the lines of several nodes do not mix.
  const std::string line =
      fmt::format("{:02}:{:02}:{:02}.{:03} {}{}{}: {}\n", local.tm_hour, local.tm_min, local.tm_sec, ms,
                  device, module.empty() ? "" : ".", module, on_one_line(text));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace takt::node
