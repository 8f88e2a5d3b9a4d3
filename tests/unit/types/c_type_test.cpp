// Tests that the C struct and the C++ class of one IDL type are encoded to the same bytes.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <takt/type.h>

#include "c_values.h"
#include "heap_watch.hpp"
#include "values.hpp"

namespace takt::c_type_test {
namespace {

using types_test::allocations_of;
using types_test::tail;
using types_test::whole;
using Bytes = std::vector<unsigned char>;

template <class T>
Bytes encoded(const T& value) {
  Bytes bytes(PortType<T>::info.max_size);
  bytes.resize(
      PortType<T>::encode(value, reinterpret_cast<std::byte*>(bytes.data()), PortType<T>::info.max_size));
  return bytes;
}

class CStruct : public testing::Test {
 protected:
  void SetUp() override {
    // Fills both structs with a pattern first, because encoding and decoding must not depend on earlier
    // contents.
    std::memset(value.get(), 0xA5, sizeof *value);
    std::memset(other.get(), 0xA5, sizeof *other);
    fill_whole(value.get());
  }
  Bytes bytes_of(const everything_Whole& from) {
    Bytes bytes(everything_Whole_type.max_size);
    bytes.resize(everything_Whole_encode(&from, bytes.data(), everything_Whole_type.max_size));
    return bytes;
  }
  bool is_encoded() { return !bytes_of(*value).empty(); }

  std::unique_ptr<everything_Whole> value = std::make_unique<everything_Whole>();
  std::unique_ptr<everything_Whole> other = std::make_unique<everything_Whole>();
};

TEST_F(CStruct, HasTheSameTypeInfoAsTheCppClass) {
  const auto& info = PortType<everything::Whole>::info;
  EXPECT_STREQ(everything_Whole_type.name, info.name);
  EXPECT_STREQ(everything_Whole_type.description, info.description);
  EXPECT_EQ(everything_Whole_type.max_size, info.max_size);
  EXPECT_EQ(everything_Whole_type.value_size, sizeof(everything_Whole));
  EXPECT_STREQ(parts_Part_type.name, "parts::Part");
  EXPECT_EQ(parts_AXES, 6);
}

TEST_F(CStruct, EncodesToTheSameBytesAsTheCppClass) { EXPECT_EQ(bytes_of(*value), encoded(whole(1))); }

TEST_F(CStruct, DecodesTheBytesThatTheCppClassEncodes) {
  for (const double fill : {1.0, 0.5, 0.0}) {
    const Bytes bytes = encoded(whole(fill));
    ASSERT_EQ(everything_Whole_decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), other.get()),
              1);
    EXPECT_EQ(bytes_of(*other), bytes);
  }
  EXPECT_STREQ(other->scalars.name, "12345678");
  EXPECT_EQ(other->scalars.mode, parts_HOLD);
  EXPECT_EQ(other->way.length, 0U);
}

TEST_F(CStruct, DecodesBigEndianBytes) {
  // These are the bytes of part(3), with the bytes of each number in reverse order.
  const Bytes bytes{0,    0,    0,    0,    3,    0,    0, 0, 0, 0, 0,   0,   0x11, 0x22,
                    0x33, 0x44, 0x55, 0x66, 0x77, 0x8B, 0, 0, 0, 3, 'a', 'b', 0};
  parts_Part part;
  ASSERT_EQ(parts_Part_decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), &part), 1);
  EXPECT_EQ(part.kind, 3);
  EXPECT_EQ(part.number, 0x112233445566778BU);
  EXPECT_STREQ(part.label, "ab");
}

TEST_F(CStruct, CanBeEncodedAndDecodedThroughItsTypeInfo) {
  Bytes bytes(everything_Whole_type.max_size);
  const std::uint32_t size =
      everything_Whole_type.encode(value.get(), bytes.data(), everything_Whole_type.max_size);
  ASSERT_EQ(size, encoded(whole(1)).size());
  EXPECT_EQ(everything_Whole_type.encode(value.get(), bytes.data(), size - 1), 0U);
  ASSERT_EQ(everything_Whole_type.decode(bytes.data(), size, other.get()), 1);
  EXPECT_EQ(bytes_of(*other), bytes_of(*value));
  EXPECT_EQ(everything_Whole_type.decode(bytes.data(), size - 1, other.get()), 0);
}

TEST_F(CStruct, IsNotEncodedIfAFieldExceedsItsBound) {
  ASSERT_TRUE(is_encoded());
  std::memset(value->scalars.name, 'x', sizeof value->scalars.name);  // the text then has no terminating zero
  EXPECT_FALSE(is_encoded());
  fill_whole(value.get());
  std::memset(value->name_list.items[2], 'x', 7);
  EXPECT_FALSE(is_encoded());
  fill_whole(value.get());
  value->mode_list.items[0] = static_cast<parts_Mode>(3);
  EXPECT_FALSE(is_encoded());
  for (const std::uint32_t length : {8U, 0xFFFFFFFFU}) {
    fill_whole(value.get());
    value->byte_list.length = length;
    EXPECT_FALSE(is_encoded());
    fill_whole(value.get());
    value->piece_list.length = length;
    EXPECT_FALSE(is_encoded());
    fill_whole(value.get());
    value->ways[1].length = length;
    EXPECT_FALSE(is_encoded());
  }
}

TEST_F(CStruct, DecodesExactlyTheBytesThatTheCppClassDecodes) {
  const Bytes right = encoded(whole(1));
  for (std::size_t at = 0; at < right.size(); ++at) {
    for (const int change : {0x01, 0x80, 0xFF}) {
      Bytes bytes = right;
      bytes[at] = static_cast<unsigned char>(bytes[at] ^ change);
      everything::Whole by_class;
      const bool is_sample =
          PortType<everything::Whole>::decode(reinterpret_cast<const std::byte*>(bytes.data()),
                                              static_cast<std::uint32_t>(bytes.size()), by_class);
      EXPECT_EQ(
          everything_Whole_decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), other.get()) == 1,
          is_sample);
      if (!is_sample) continue;
      EXPECT_EQ(bytes_of(*other), encoded(by_class));
    }
  }
}

TEST_F(CStruct, IsEncodedAndDecodedWithoutAllocatingMemory) {
  if (!types_test::kHeapIsWatched) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  Bytes bytes(everything_Whole_type.max_size);
  std::uint32_t size = 0;
  int decoded = 0;
  EXPECT_EQ(allocations_of([&] {
              size = everything_Whole_encode(value.get(), bytes.data(), everything_Whole_type.max_size);
              decoded = everything_Whole_decode(bytes.data(), size, other.get());
            }),
            0U);
  EXPECT_EQ(decoded, 1);
}

}  // namespace
}  // namespace takt::c_type_test
