#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <gtest/gtest.h>
#include <parts.hpp>

#include "heap_watch.hpp"
#include "values.hpp"

namespace takt::port_type_test {
namespace {

using eprosima::fastcdr::Cdr;
using types_test::allocations_of;
using types_test::part;
using types_test::scalars;
using types_test::tail;
using types_test::whole;
using Bytes = std::vector<std::byte>;

/// Returns the bytes that Fast DDS would send for this value.
template <class T>
Bytes by_fast_cdr(const T& value, Cdr::Endianness endianness) {
  Bytes bytes(PortType<T>::info.max_size);
  eprosima::fastcdr::FastBuffer buffer{reinterpret_cast<char*>(bytes.data()), bytes.size()};
  Cdr cdr{buffer, endianness, Cdr::DDS_CDR};
  cdr.serialize_encapsulation();
  value.serialize(cdr);
  bytes.resize(cdr.getSerializedDataLength());
  return bytes;
}

template <class T>
Bytes encoded(const T& value) {
  Bytes bytes(PortType<T>::info.max_size, std::byte{0xEE});  // encode() must set the padding to zero
  bytes.resize(PortType<T>::encode(value, bytes.data(), PortType<T>::info.max_size));
  return bytes;
}

template <class T>
bool decodes(const Bytes& bytes, T& value) {
  return PortType<T>::decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), value);
}
template <class T>
bool decodes(const Bytes& bytes) {
  T value;
  return decodes(bytes, value);
}

struct Full {
  using Type = everything::Whole;
  static Type value() { return whole(1); }
};
struct Half {
  using Type = everything::Whole;
  static Type value() { return whole(0.5); }
};
struct Empty {
  using Type = everything::Whole;
  static Type value() { return whole(0); }
};
struct New {
  using Type = everything::Whole;
  static Type value() { return {}; }
};
struct Nested {
  using Type = everything::Tail;
  static Type value() { return tail(); }
};
struct OnlyScalars {
  using Type = everything::Scalars;
  static Type value() { return scalars(); }
};
struct OfAnotherFile {
  using Type = parts::Part;
  static Type value() { return part(3); }
};

template <class Case>
class EveryValue : public testing::Test {};
using Cases = testing::Types<Full, Half, Empty, New, Nested, OnlyScalars, OfAnotherFile>;
TYPED_TEST_SUITE(EveryValue, Cases);

TYPED_TEST(EveryValue, EncodesToTheSameBytesAsFastCdr) {
  const auto value = TypeParam::value();
  EXPECT_EQ(encoded(value), by_fast_cdr(value, Cdr::LITTLE_ENDIANNESS));
}

TYPED_TEST(EveryValue, IsDecodedFromEitherByteOrder) {
  const auto value = TypeParam::value();
  for (const auto endianness : {Cdr::LITTLE_ENDIANNESS, Cdr::BIG_ENDIANNESS}) {
    typename TypeParam::Type other;
    ASSERT_TRUE(decodes(by_fast_cdr(value, endianness), other));
    EXPECT_EQ(other, value);
  }
}

TYPED_TEST(EveryValue, ReplacesAllPreviousContentsWhenDecoded) {
  using T = typename TypeParam::Type;
  const T value = TypeParam::value();
  T other = TypeParam::value();
  ASSERT_TRUE(decodes(by_fast_cdr(T{}, Cdr::BIG_ENDIANNESS), other));
  EXPECT_EQ(other, T{});
  ASSERT_TRUE(decodes(encoded(value), other));
  EXPECT_EQ(other, value);
}

TYPED_TEST(EveryValue, IsEncodedAndDecodedWithoutAllocation) {
  if (!types_test::kHeapIsWatched) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  using T = typename TypeParam::Type;
  const T value = TypeParam::value();
  Bytes bytes(PortType<T>::info.max_size);
  const auto capacity = static_cast<std::uint32_t>(bytes.size());
  const Bytes big = by_fast_cdr(value, Cdr::BIG_ENDIANNESS);
  T other;
  PortType<T>::reserve(other);
  std::uint32_t size = 0;
  bool decoded = false;
  EXPECT_EQ(allocations_of([&] { size = PortType<T>::encode(value, bytes.data(), capacity); }), 0U);
  EXPECT_EQ(allocations_of([&] { decoded = PortType<T>::decode(bytes.data(), size, other); }), 0U);
  EXPECT_TRUE(decoded);
  EXPECT_EQ(allocations_of([&] { decoded = decodes(big, other); }), 0U);
  EXPECT_TRUE(decoded);
  // A failed call does not allocate either.
  EXPECT_EQ(allocations_of([&] { decoded = PortType<T>::decode(bytes.data(), size / 2, other); }), 0U);
  EXPECT_FALSE(decoded);
  EXPECT_EQ(allocations_of([&] { size = PortType<T>::encode(value, bytes.data(), size - 1); }), 0U);
  EXPECT_EQ(size, 0U);
}

TEST(HeapWatch, CountsAllocations) {
  if (!types_test::kHeapIsWatched) GTEST_SKIP() << "the sanitizer has an allocator of its own";
  std::vector<int> numbers;
  EXPECT_EQ(allocations_of([&] { numbers.resize(100); }), 1U);
  EXPECT_EQ(allocations_of([&] { numbers.resize(50); }), 0U);
  // decode() also works without reserve(), but then it allocates.
  everything::Whole value;
  EXPECT_GT(allocations_of([bytes = encoded(whole(1)), &value] { EXPECT_TRUE(decodes(bytes, value)); }), 5U);
}

TYPED_TEST(EveryValue, IsEncodedOnlyIfTheBufferIsLargeEnough) {
  using T = typename TypeParam::Type;
  const T value = TypeParam::value();
  const Bytes right = encoded(value);
  EXPECT_TRUE(PortType<T>::fits(value));
  for (std::uint32_t size = 0; size <= right.size(); ++size) {
    Bytes bytes(size + 1, std::byte{0x5A});  // encode() must not change the last byte
    EXPECT_EQ(PortType<T>::encode(value, bytes.data(), size), size == right.size() ? size : 0);
    EXPECT_EQ(bytes.back(), std::byte{0x5A});
  }
}

TYPED_TEST(EveryValue, IsRejectedIfItsBytesAreTruncated) {
  using T = typename TypeParam::Type;
  Bytes bytes = encoded(TypeParam::value());
  while (!bytes.empty()) {
    bytes.pop_back();
    EXPECT_FALSE(decodes<T>(bytes)) << bytes.size();
  }
}

TYPED_TEST(EveryValue, MayBeFollowedByUpToThreePaddingBytes) {
  using T = typename TypeParam::Type;
  Bytes bytes = encoded(TypeParam::value());
  for (int i = 0; i < 3; ++i) {
    bytes.push_back(std::byte{0xFF});
    EXPECT_TRUE(decodes<T>(bytes));
  }
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(decodes<T>(bytes));
}

TEST(PortType, ContainsTheMaximumSizeOfItsSamples) {
  // parts::Part has `kind` at byte 0, `number` at 8, the length of `label` at 16, and its 7 characters and
  // terminating zero at 20. These 28 bytes follow 4 bytes of encapsulation.
  EXPECT_EQ(PortType<parts::Part>::info.max_size, 32U);
  EXPECT_STREQ(PortType<parts::Part>::info.name, "parts::Part");
  EXPECT_STREQ(PortType<everything::deep::Bottom>::info.name, "everything::deep::Bottom");
  EXPECT_EQ(PortType<everything::deep::Bottom>::info.max_size, 20U);
  // whole() fills almost every field up to its bound, but leaves a few labels shorter.
  EXPECT_LE(encoded(whole(1)).size(), PortType<everything::Whole>::info.max_size);
}

TEST(PortType, DescribesItsFieldsAsJson) {
  EXPECT_STREQ(
      PortType<parts::Part>::info.description,
      R"({"name":"parts::Part","fields":[{"name":"kind","type":"octet"},)"
      R"({"name":"number","type":"unsigned long long"},{"name":"label","type":"string","bound":7}]})");
}

TEST(PortType, ReservesTheMaximumLengthOfEachSequence) {
  everything::Tail value;
  PortType<everything::Tail>::reserve(value);
  EXPECT_EQ(value.end().capacity(), 3U);
  for (const everything::Whole* each : {&value.first(), &value.rest()[0], &value.rest()[1]}) {
    EXPECT_GE(each->flag_list().capacity(), 5U);
    EXPECT_EQ(each->piece_list().capacity(), 3U);
    EXPECT_EQ(each->ways()[1].capacity(), 4U);
    EXPECT_EQ(each->longs()[1].capacity(), 2U);
  }
}

// ---- Values that do not fit their type

template <class F>
bool is_encoded(F change) {
  everything::Whole value = whole(1);
  change(value);
  EXPECT_EQ(PortType<everything::Whole>::fits(value), !encoded(value).empty());
  return !encoded(value).empty();
}

TEST(PortType, RejectsASequenceLongerThanItsBound) {
  EXPECT_TRUE(is_encoded([](auto&) {}));
  EXPECT_FALSE(is_encoded([](auto& v) { v.flag_list().resize(6); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.byte_list().resize(8); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.real_list().resize(5); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.name_list().resize(4); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.mode_list().resize(4); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.piece_list().resize(4); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.plate_list().resize(3); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.ways()[1].resize(5); }));
}

TEST(PortType, RejectsAnInvalidEnumerator) {
  EXPECT_FALSE(is_encoded([](auto& v) { v.scalars().mode(static_cast<parts::Mode>(3)); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.modes()[2] = static_cast<parts::Mode>(0xFFFFFFFF); }));
  EXPECT_FALSE(is_encoded([](auto& v) { v.mode_list()[0] = static_cast<parts::Mode>(3); }));
}

TEST(PortType, EncodesAStringUpToItsFirstZeroByte) {
  parts::Part value;
  value.label().assign("ab\0cd", 5);
  parts::Part other;
  ASSERT_TRUE(decodes(encoded(value), other));
  EXPECT_STREQ(other.label().c_str(), "ab");
  // assign() leaves the old characters in memory after the new text.
  value.label("1234567");
  value.label().assign("xy", 2);
  ASSERT_TRUE(decodes(encoded(value), other));
  EXPECT_STREQ(other.label().c_str(), "xy");
}

// ---- Invalid bytes

/// Changes one byte of a valid sample of parts::Part and decodes it. After 4 bytes of encapsulation, the
/// sample has `kind` at byte 4, `number` at 12, the length of `label` at 20, and the text of `label` at 24.
class SampleDecoder : public testing::Test {
 protected:
  Bytes bytes = encoded(part(3));
  bool with(std::size_t at, std::uint8_t value) {
    Bytes changed = bytes;
    changed.at(at) = std::byte{value};
    return decodes<parts::Part>(changed);
  }
};

TEST_F(SampleDecoder, AcceptsOnlyTheEncapsulationOfPlainCdr) {
  EXPECT_FALSE(with(1, 2));  // the encapsulation of a parameter list
  EXPECT_FALSE(with(1, 7));  // the encapsulation of XCDR2
  EXPECT_FALSE(with(0, 1));
  EXPECT_TRUE(with(2, 0xFF));  // the decoder ignores the options in bytes 2 and 3
  EXPECT_TRUE(with(3, 3));     // Cyclone DDS stores the number of padding bytes here
}

TEST_F(SampleDecoder, RejectsAStringWithoutATerminatingZero) {
  ASSERT_EQ(bytes.size(), 28U);
  EXPECT_TRUE(with(24, 'x'));
  EXPECT_FALSE(with(27, 'x'));  // the last character is not zero
  EXPECT_FALSE(with(25, 0));    // a zero before the end of the string
  EXPECT_FALSE(with(20, 0));    // the length must include the terminating zero
  EXPECT_FALSE(with(20, 5));    // the string would be longer than the sample
  EXPECT_FALSE(with(20, 3));    // the string would end at its third character, which is not zero
  EXPECT_FALSE(with(23, 0xFF));
  parts::Part longest = part(7);
  bytes = encoded(longest);
  EXPECT_TRUE(decodes<parts::Part>(bytes));
  bytes[20] = std::byte{9};  // 8 characters and a zero fit the sample, but the bound is 7 characters
  bytes.push_back(std::byte{0});
  bytes[31] = std::byte{'x'};
  EXPECT_FALSE(decodes<parts::Part>(bytes));
}

TEST(DecodedBoolean, IsRejectedUnlessZeroOrOne) {
  Bytes bytes = encoded(scalars());
  for (int value = 0; value < 256; ++value) {
    bytes[4] = static_cast<std::byte>(value);
    EXPECT_EQ(decodes<everything::Scalars>(bytes), value < 2);
  }
}

TEST(DecodedEnumerator, IsRejectedIfTheEnumDoesNotDefineIt) {
  Bytes bytes = encoded(scalars());
  const std::size_t mode = bytes.size() - 4;
  for (const std::uint32_t value : {0U, 1U, 2U, 3U, 256U, 0x80000000U, 0xFFFFFFFFU}) {
    std::memcpy(&bytes[mode], &value, sizeof value);
    EXPECT_EQ(decodes<everything::Scalars>(bytes), value < 3) << value;
  }
}

TEST(DecodedSequence, IsRejectedIfItsLengthExceedsItsBound) {
  const Bytes right = encoded(tail());
  const std::size_t end = right.size() - 7;  // the position of the length of the sequence `end`
  for (const std::uint32_t value : {0U, 2U, 3U, 4U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
    Bytes bytes = right;
    std::memcpy(&bytes[end], &value, sizeof value);
    // A smaller length leaves at most 3 bytes unused, which count as padding.
    EXPECT_EQ(decodes<everything::Tail>(bytes), value <= 3) << value;
  }
}

TEST(DecodedNumber, MayBeNanOrInfinite) {
  everything::Scalars value = scalars();
  const float float_nan = std::numeric_limits<float>::quiet_NaN();
  value.single(-float_nan);
  value.real(-std::numeric_limits<double>::infinity());
  value.letter(static_cast<char>(0xE9));
  for (const auto endianness : {Cdr::LITTLE_ENDIANNESS, Cdr::BIG_ENDIANNESS}) {
    everything::Scalars other;
    ASSERT_TRUE(decodes(by_fast_cdr(value, endianness), other));
    EXPECT_TRUE(std::isnan(other.single()) && std::signbit(other.single()));
    EXPECT_EQ(other.real(), value.real());
    EXPECT_EQ(other.letter(), value.letter());
  }
}

}  // namespace
}  // namespace takt::port_type_test
