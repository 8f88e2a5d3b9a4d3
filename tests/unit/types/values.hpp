// Functions that make example values of the types in everything.idl.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include <everything.hpp>

namespace takt::types_test {

inline parts::Part part(std::uint8_t kind) {
  parts::Part value;
  value.kind(kind);
  value.number(0x1122334455667788ULL + kind);
  value.label(std::string(kind % 8, 'p'));
  return value;
}

inline everything::Scalars scalars() {
  everything::Scalars value;
  value.flag(true);
  value.byte(200);
  value.letter('L');
  value.small(-2);
  value.usmall(65000);
  value.whole(-70000);
  value.uwhole(4000000000U);
  value.big(-5000000000);
  value.ubig(18000000000000000000U);
  value.single(1.5F);
  value.real(-2.25);
  value.i8(-8);
  value.u8(8);
  value.i16(-16);
  value.u16(16);
  value.i32(-32);
  value.u32(32);
  value.i64(-64);
  value.u64(64);
  value.name("12345678");
  value.mode(parts::HOLD);
  return value;
}

/// Returns the value of scalars() with NaN, infinity, and a character that is not ASCII.
inline everything::Scalars odd_numbers() {
  everything::Scalars value = scalars();
  value.single(-std::numeric_limits<float>::quiet_NaN());
  value.real(-std::numeric_limits<double>::infinity());
  value.letter(static_cast<char>(0xE9));
  return value;
}

/// Returns a value in which each sequence has `fill` times its maximum length: 0 means empty, 1 means full.
inline everything::Whole whole(double fill = 1) {
  const auto n = [fill](std::size_t bound) {
    return static_cast<std::size_t>(fill * static_cast<double>(bound));
  };
  everything::Whole value;
  value.scalars(scalars());
  value.label("1234567");
  value.piece(part(7));
  value.bottom().mark('B');
  value.bottom().depth(11000.5);
  value.flags({true, false, true});
  value.letters({'h', 'e', 'l', 'l', 'o'});
  double next = 0.5;
  for (auto& row : value.matrix())
    for (double& cell : row) cell = next++;
  value.names({{{"", "a"}, {"bb", "cccc"}}});
  value.modes({parts::OFF, parts::ON, parts::HOLD});
  std::int32_t number = -3;
  for (auto& row : value.pieces())
    for (auto& piece : row) piece = part(static_cast<std::uint8_t>(++number + 10));
  for (auto& row : value.plate())
    for (auto& cell : row) cell = number++;
  for (auto& plate : value.plates())
    for (auto& row : plate)
      for (auto& cell : row) cell = number++ * 1000;
  for (std::size_t i = 0; i < n(5); ++i) value.flag_list().push_back(i % 2 == 0);
  for (std::size_t i = 0; i < n(7); ++i) value.byte_list().push_back(static_cast<std::uint8_t>(250 + i));
  for (std::size_t i = 0; i < n(3); ++i) value.letter_list().push_back(static_cast<char>('x' + i));
  for (std::size_t i = 0; i < n(3); ++i)
    value.small_list().push_back(static_cast<std::int16_t>(-1000 * static_cast<int>(i)));
  for (std::size_t i = 0; i < n(4); ++i) value.real_list().push_back(1.0 / static_cast<double>(i + 1));
  for (std::size_t i = 0; i < n(3); ++i) value.name_list().emplace_back(std::string(6 - i, 'n'));
  for (std::size_t i = 0; i < n(3); ++i) value.mode_list().push_back(static_cast<parts::Mode>(2 - i));
  for (std::size_t i = 0; i < n(3); ++i) value.piece_list().push_back(part(static_cast<std::uint8_t>(i + 5)));
  value.plate_list().assign(n(2), value.plate());
  for (std::size_t i = 0; i < n(6); ++i) value.label_list().emplace_back(std::string(i + 2, 'l'));
  value.way().assign(n(4), 3.5);
  value.ways()[0].assign(n(4), 4.5);
  value.ways()[1].assign(n(4) / 2, 5.5);
  value.longs()[0].assign(n(2) / 2, -6);
  value.longs()[1].assign(n(2), 7);
  value.last(1);
  value.more({2, 3});
  return value;
}

inline everything::Tail tail() {
  everything::Tail value;
  value.first(whole(1));
  value.rest({whole(0.5), whole(0)});
  value.end({1, 2, 3});
  return value;
}

}  // namespace takt::types_test
