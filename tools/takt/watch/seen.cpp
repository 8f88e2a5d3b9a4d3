#include "watch/seen.hpp"

#include <algorithm>
#include <ctime>

#include <fmt/format.h>

namespace takt::tool::watch {

namespace {

template <class T>
const T* named(const std::vector<T>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const T& one) { return one.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace

std::optional<double> Module::share(double run_us) const {
  if (!measured || measured->cycles == 0 || !planned || !planned->budget) return std::nullopt;
  return run_us * 1e3 / static_cast<double>(planned->budget->count());
}

const Device* Snapshot::device(const std::string& target) const {
  return named(devices, target.substr(0, target.find('.')));
}

const Module* Snapshot::module(const std::string& target) const {
  const std::size_t dot = target.find('.');
  const Device* const on = device(target);
  return on == nullptr || dot == std::string::npos ? nullptr : named(on->modules, target.substr(dot + 1));
}

std::string clock_text(std::int64_t wall_ns) {
  const std::time_t seconds = wall_ns / 1'000'000'000;
  std::tm parts{};
  ::localtime_r(&seconds, &parts);
  return fmt::format("{:02}:{:02}:{:02}.{:03}", parts.tm_hour, parts.tm_min, parts.tm_sec,
                     wall_ns / 1'000'000 % 1000);
}

}  // namespace takt::tool::watch
