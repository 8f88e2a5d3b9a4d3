#include <takt/core/time.hpp>

#include <array>
#include <cstdio>

namespace takt {

std::string to_text(Nanoseconds duration) {
  struct Unit {
    std::int64_t ns;
    const char* name;
  };
  constexpr std::array units{Unit{1'000'000'000, "s"}, Unit{1'000'000, "ms"}, Unit{1'000, "us"}};

  const std::int64_t ns = duration.count();
  for (const Unit& unit : units) {
    const std::int64_t thousandth = unit.ns / 1000;
    if (ns % thousandth != 0 || (ns < unit.ns && ns > -unit.ns)) continue;
    std::string text = std::to_string(ns / unit.ns);
    std::int64_t rest = ns % unit.ns / thousandth;
    if (rest < 0) rest = -rest;
    if (rest != 0) {
      std::array<char, 8> decimals{};
      std::snprintf(decimals.data(), decimals.size(), ".%03d", static_cast<int>(rest));
      text += decimals.data();
      while (text.back() == '0') text.pop_back();
    }
    return text + " " + unit.name;
  }
  return std::to_string(ns) + " ns";
}

}  // namespace takt
