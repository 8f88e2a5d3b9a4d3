#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <parts.hpp>

#include "heap_watch.hpp"
#include "reference.hpp"
#include "values.hpp"

namespace takt::port_type_test {
namespace {

using types_reference::by_fast_cdr;
using types_reference::Bytes;
using types_reference::encoded;
using types_reference::Endianness;
using types_test::allocations_of;
using types_test::part;
using types_test::scalars;
using types_test::tail;
using types_test::whole;

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
  static constexpr const char* kName = "whole 1";
  using Type = everything::Whole;
  static Type value() { return whole(1); }
};
struct Half {
  static constexpr const char* kName = "whole 0.5";
  using Type = everything::Whole;
  static Type value() { return whole(0.5); }
};
struct Empty {
  static constexpr const char* kName = "whole 0";
  using Type = everything::Whole;
  static Type value() { return whole(0); }
};
struct New {
  static constexpr const char* kName = "new";
  using Type = everything::Whole;
  static Type value() { return {}; }
};
struct Nested {
  static constexpr const char* kName = "tail";
  using Type = everything::Tail;
  static Type value() { return tail(); }
};
struct OnlyScalars {
  static constexpr const char* kName = "scalars";
  using Type = everything::Scalars;
  static Type value() { return scalars(); }
};
struct OfAnotherFile {
  static constexpr const char* kName = "part";
  using Type = parts::Part;
  static Type value() { return part(3); }
};

template <class Case>
class EveryValue : public testing::Test {};
using Cases = testing::Types<Full, Half, Empty, New, Nested, OnlyScalars, OfAnotherFile>;
TYPED_TEST_SUITE(EveryValue, Cases);

TYPED_TEST(EveryValue, IsEncodedToTheBytesThatFastDdsSends) {
  // Both sides encode the same value, which a function in values.hpp makes. Here, Takt's generator made the
  // class of the value; in reference.cpp, fastddsgen made it.
  EXPECT_EQ(encoded(TypeParam::value()), types_reference::sample_of_fast_dds(TypeParam::kName));
}

TYPED_TEST(EveryValue, IsDecodedFromEitherByteOrder) {
  const auto value = TypeParam::value();
  for (const auto endianness : {Endianness::little, Endianness::big}) {
    typename TypeParam::Type other;
    ASSERT_TRUE(decodes(by_fast_cdr(value, endianness), other));
    EXPECT_EQ(other, value);
  }
}

TYPED_TEST(EveryValue, ReplacesAllPreviousContentsWhenDecoded) {
  using T = typename TypeParam::Type;
  const T value = TypeParam::value();
  T other = TypeParam::value();
  ASSERT_TRUE(decodes(by_fast_cdr(T{}, Endianness::big), other));
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
  const Bytes big = by_fast_cdr(value, Endianness::big);
  T other;
  PortType<T>::reserve(other);
  std::uint32_t size = 0;
  bool decoded = false;
  EXPECT_EQ(allocations_of([&] { size = PortType<T>::encode(value, bytes.data(), capacity); }), 0U);
  EXPECT_EQ(allocations_of([&] { decoded = PortType<T>::decode(bytes.data(), size, other); }), 0U);
  EXPECT_TRUE(decoded);
  EXPECT_EQ(allocations_of([&] { decoded = decodes(big, other); }), 0U);
  EXPECT_TRUE(decoded);
  // A failed call of decode() or encode() must not allocate either.
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
  // decode() also works if reserve() was not called, but then it allocates.
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
  // parts::Part has `kind` at byte 0, `number` at byte 8, the length of `label` at byte 16, and at byte 20
  // the 7 characters and the terminating zero of `label`. These 28 bytes follow 4 bytes of encapsulation.
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
  value.label("1234567");
  value.label().assign("xy", 2);
  ASSERT_TRUE(decodes(encoded(value), other));
  EXPECT_STREQ(other.label().c_str(), "xy");
}

// ---- The classes

/// True if T has the functions for a field `kind` whose type is a basic type or an enum.
template <class T, class Value>
constexpr bool has_accessors = requires(T value, const T constant) {
  { constant.kind() } -> std::same_as<Value>;
  { value.kind() } -> std::same_as<Value&>;
  value.kind(Value{});
};
/// True if T has the functions for a field `label` whose type is neither a basic type nor an enum.
template <class T, class Value>
constexpr bool has_reference_accessors = requires(T value, const T constant, const Value& copied,
                                                  Value&& moved) {
  { constant.label() } -> std::same_as<const Value&>;
  { value.label() } -> std::same_as<Value&>;
  value.label(copied);
  value.label(std::move(moved));
};

TEST(PortClass, HasTheFunctionsThatFastddsgenGenerates) {
  static_assert(has_accessors<parts::Part, std::uint8_t>);
  static_assert(has_reference_accessors<parts::Part, BoundedString<7>>);
  static_assert(std::is_nothrow_move_constructible_v<everything::Whole>);
  static_assert(std::is_nothrow_move_assignable_v<everything::Tail>);
  static_assert(std::is_same_v<std::underlying_type_t<parts::Mode>, std::uint32_t>);
  static_assert(std::is_same_v<everything::Piece, parts::Part>);
  static_assert(std::is_same_v<everything::Grid, std::array<std::array<std::int32_t, 3>, 2>>);
  static_assert(parts::AXES == 6 && everything::COLUMNS == 3);
}

TEST(PortClass, IsCopiedAsPlainMemoryUnlessItHasASequence) {
  static_assert(std::is_trivially_copyable_v<everything::Scalars>);
  static_assert(std::is_trivially_copyable_v<parts::Part>);
}

TEST(PortClass, StartsWithZerosAndEmptyTexts) {
  // Fills the memory with other contents before the object is constructed.
  alignas(everything::Scalars) std::array<std::byte, sizeof(everything::Scalars)> memory;
  memory.fill(std::byte{0xA5});
  const auto* value = new (memory.data()) everything::Scalars;
  EXPECT_EQ(*value, everything::Scalars{});
  EXPECT_EQ(value->real(), 0);
  EXPECT_EQ(value->mode(), parts::OFF);
  EXPECT_STREQ(value->name().c_str(), "");
}

TEST(PortClass, ComparesEachField) {
  const everything::Whole value = whole(1);
  EXPECT_EQ(value, whole(1));
  EXPECT_NE(value, whole(0.5));
  everything::Whole other = value;
  other.names()[1][1] = "cc";
  EXPECT_NE(value, other);
  other = value;
  other.scalars().u64(65);
  EXPECT_NE(value, other);
}

TEST(PortClass, MovesItsSequences) {
  everything::Tail value = tail();
  const std::uint8_t* at = value.end().data();
  everything::Tail moved = std::move(value);
  EXPECT_EQ(moved.end().data(), at);
  EXPECT_EQ(moved, tail());
  std::vector<std::uint8_t> bytes{7, 8, 9};
  at = bytes.data();
  moved.end(std::move(bytes));
  EXPECT_EQ(moved.end().data(), at);
}

// ---- Invalid bytes

/// Changes one byte of a valid sample of parts::Part and decodes the result. After 4 bytes of encapsulation,
/// the sample has `kind` at byte 4, `number` at byte 12, the length of `label` at byte 20, and the text of
/// `label` at byte 24.
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
  EXPECT_FALSE(with(1, 2));  // 2 is the encapsulation of a parameter list
  EXPECT_FALSE(with(1, 7));  // 7 is the encapsulation of XCDR2
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
    // A length below 3 leaves at most 3 bytes unused, which count as padding.
    EXPECT_EQ(decodes<everything::Tail>(bytes), value <= 3) << value;
  }
}

TEST(DecodedNumber, MayBeNanOrInfinite) {
  const everything::Scalars value = types_test::odd_numbers();
  for (const auto endianness : {Endianness::little, Endianness::big}) {
    everything::Scalars other;
    ASSERT_TRUE(decodes(by_fast_cdr(value, endianness), other));
    EXPECT_TRUE(std::isnan(other.single()) && std::signbit(other.single()));
    EXPECT_EQ(other.real(), value.real());
    EXPECT_EQ(other.letter(), value.letter());
  }
}

}  // namespace
}  // namespace takt::port_type_test
