#include <components/common/modbus_value.hpp>

#include <array>
#include <limits>

#include <gtest/gtest.h>

namespace modbus::modbus_value_test {
namespace {

std::array<std::uint16_t, 2> encoded(const Encoding& encoding, double value) {
  std::array<std::uint16_t, 2> words{0xAAAA, 0xAAAA};
  EXPECT_TRUE(encode(encoding, value, words.data()));
  return words;
}

TEST(ModbusValue, DoesNotChangeTheRegisterAfterIt) {
  EXPECT_EQ(encoded({.type = Type::uint16}, 0x1234), (std::array<std::uint16_t, 2>{0x1234, 0xAAAA}));
  EXPECT_EQ(encoded({.type = Type::int16}, -2), (std::array<std::uint16_t, 2>{0xFFFE, 0xAAAA}));
}

TEST(ModbusValue, HasItsHighWordFirstByDefault) {
  EXPECT_EQ(encoded({.type = Type::uint32}, 0x12345678), (std::array<std::uint16_t, 2>{0x1234, 0x5678}));
  EXPECT_EQ(encoded({.type = Type::uint32, .low_first = true}, 0x12345678),
            (std::array<std::uint16_t, 2>{0x5678, 0x1234}));
  EXPECT_EQ(encoded({.type = Type::uint32, .bytes_swapped = true}, 0x12345678),
            (std::array<std::uint16_t, 2>{0x3412, 0x7856}));
  EXPECT_EQ(encoded({.type = Type::uint32, .low_first = true, .bytes_swapped = true}, 0x12345678),
            (std::array<std::uint16_t, 2>{0x7856, 0x3412}));
  EXPECT_EQ(encoded({.type = Type::int32}, -2), (std::array<std::uint16_t, 2>{0xFFFF, 0xFFFE}));
  // In IEEE 754, 1.0 is 0x3F800000.
  EXPECT_EQ(encoded({.type = Type::float32}, 1), (std::array<std::uint16_t, 2>{0x3F80, 0}));
  EXPECT_EQ(encoded({.type = Type::float32, .low_first = true}, 1),
            (std::array<std::uint16_t, 2>{0, 0x3F80}));
}

TEST(ModbusValue, SurvivesARoundTripThroughRegisters) {
  for (const int order : {0, 1, 2, 3}) {
    for (const Type type : {Type::uint16, Type::int16, Type::uint32, Type::int32, Type::float32}) {
      const Encoding encoding{
          .type = type, .scale = 0.5, .offset = 3, .low_first = order % 2 == 1, .bytes_swapped = order >= 2};
      const Range raw = raw_range(type);
      for (const double x : {raw.min, raw.min / 2, 0.0, 1.0, 77.0, raw.max}) {
        const double value = std::max(std::round(x), raw.min) * 0.5 + 3;
        EXPECT_DOUBLE_EQ(decode(encoding, encoded(encoding, value).data()), value) << static_cast<int>(type);
      }
    }
  }
}

TEST(ModbusValue, IsRoundedToTheScale) {
  const Encoding encoding{.type = Type::int16, .scale = 0.1};
  EXPECT_EQ(encoded(encoding, 20.06)[0], 201);
  EXPECT_DOUBLE_EQ(decode(encoding, encoded(encoding, -20.06).data()), -20.1);
}

TEST(ModbusValue, IsClampedToTheRangeOfItsType) {
  EXPECT_EQ(encoded({.type = Type::uint16}, 70000)[0], 65535);
  EXPECT_EQ(encoded({.type = Type::uint16}, -1)[0], 0);
  EXPECT_EQ(encoded({.type = Type::int16}, -40000)[0], 0x8000);
  EXPECT_EQ(encoded({.type = Type::uint16}, std::numeric_limits<double>::infinity())[0], 65535);
  EXPECT_EQ(decode({.type = Type::int32}, encoded({.type = Type::int32}, 1e30).data()), 2147483647);
  EXPECT_EQ(decode({.type = Type::float32}, encoded({.type = Type::float32}, 1e300).data()),
            static_cast<double>(std::numeric_limits<float>::max()));
  // With scale -1, a uint16 register holds the values from -65535 to 0. So 5 becomes 0.
  EXPECT_EQ(decode({.scale = -1}, encoded({.scale = -1}, 5).data()), 0);
}

TEST(ModbusValue, CannotBeNan) {
  std::array<std::uint16_t, 2> words{1, 2};
  EXPECT_FALSE(encode({}, std::numeric_limits<double>::quiet_NaN(), words.data()));
  EXPECT_EQ(words, (std::array<std::uint16_t, 2>{1, 2}));
}

TEST(ModbusValue, IsCheckedAgainstTheRangeOfItsType) {
  EXPECT_TRUE(fits({.type = Type::int16, .scale = 0.1}, 3276.7));
  EXPECT_FALSE(fits({.type = Type::int16, .scale = 0.1}, 3277));
  EXPECT_EQ(range_text({.type = Type::int16, .scale = -0.1}), "-3276.7 to 3276.8");
}

}  // namespace
}  // namespace modbus::modbus_value_test
