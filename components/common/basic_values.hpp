// Creates samples of the types in idl/basic.idl, for tests.
#pragma once

#include <basic.hpp>

#include <cstdint>

namespace common {

inline basic::Number number(double value) {
  basic::Number number;
  number.value(value);
  return number;
}
inline basic::Flag flag(bool value) {
  basic::Flag flag;
  flag.value(value);
  return flag;
}
inline basic::Count count(std::int64_t value) {
  basic::Count count;
  count.value(value);
  return count;
}

}  // namespace common
