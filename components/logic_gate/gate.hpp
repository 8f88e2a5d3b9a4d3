// The mathematics of the component logic_gate: a gate with several inputs. Real-time threads may use
// everything here.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <string_view>

namespace logic_gate {

enum class Function { all_of, any_of, odd, not_all_of, none_of };

/// Returns the function with this name: "and", "or", "xor", "nand", "nor" or "not". "not" is the same as
/// "nor" and is meant for one input.
constexpr std::optional<Function> function_of(std::string_view name) noexcept {
  if (name == "and") return Function::all_of;
  if (name == "or") return Function::any_of;
  if (name == "xor") return Function::odd;
  if (name == "nand") return Function::not_all_of;
  if (name == "nor" || name == "not") return Function::none_of;
  return std::nullopt;
}

/// Returns the output of the gate. A set of inputs is a bit mask: bit 0 is input 1. `used` holds the
/// connected inputs and is not empty; `given` holds the inputs that are true. xor is true if an odd number of
/// inputs is true.
constexpr bool output(Function function, std::uint32_t used, std::uint32_t given) noexcept {
  given &= used;
  switch (function) {
    case Function::all_of:
      return given == used;
    case Function::any_of:
      return given != 0;
    case Function::odd:
      return std::popcount(given) % 2 != 0;
    case Function::not_all_of:
      return given != used;
    case Function::none_of:
      return given == 0;
  }
  return false;
}

}  // namespace logic_gate
