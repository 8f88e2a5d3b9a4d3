#include <takt/core/cdr.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace takt::cdr_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Returns the bytes that `put` writes into a buffer of `room` bytes. Returns no bytes if the buffer is too
/// small.
template <class F>
Bytes written(F put, std::size_t room = 64) {
  Bytes bytes(room, 0xEE);
  CdrWriter to{reinterpret_cast<std::byte*>(bytes.data()), bytes.size()};
  put(to);
  bytes.resize(to.size());
  return bytes;
}

CdrReader reader(const Bytes& bytes) {
  return CdrReader{reinterpret_cast<const std::byte*>(bytes.data()), bytes.size()};
}

TEST(CdrWriter, StartsWithTheEncapsulation) {
  EXPECT_EQ(written([](CdrWriter&) {}), (Bytes{0, 1, 0, 0}));
  EXPECT_EQ(written([](CdrWriter&) {}, 4), (Bytes{0, 1, 0, 0}));
  for (const std::size_t room : {0U, 1U, 2U, 3U}) EXPECT_EQ(written([](CdrWriter&) {}, room), Bytes{});
}

TEST(CdrWriter, AlignsValuesRelativeToTheEncapsulation) {
  EXPECT_EQ(written([](CdrWriter& to) {
              to.put(std::uint8_t{1});
              to.put(std::uint16_t{2});
              to.put(std::uint8_t{3});
              to.put(std::uint64_t{4});
            }),
            (Bytes{0, 1, 0, 0, 1, 0, 2, 0, 3, 0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(CdrWriter, AddsNoPaddingBeforeAnEmptyArray) {
  EXPECT_EQ(written([](CdrWriter& to) {
              to.put_length(0, 3);
              to.put_array(static_cast<const double*>(nullptr), 0);
              to.put(std::uint8_t{1});
            }),
            (Bytes{0, 1, 0, 0, 0, 0, 0, 0, 1}));
}

TEST(CdrWriter, EndsAStringWithAZeroByte) {
  EXPECT_EQ(written([](CdrWriter& to) { to.put_text("abc", 2, 2); }),
            (Bytes{0, 1, 0, 0, 3, 0, 0, 0, 'a', 'b', 0}));
  EXPECT_EQ(written([](CdrWriter& to) { to.put_text("", 0, 2); }), (Bytes{0, 1, 0, 0, 1, 0, 0, 0, 0}));
  EXPECT_EQ(written([](CdrWriter& to) { to.put_text("abc", 3, 2); }), Bytes{});
}

TEST(CdrWriter, WritesNothingAfterAValueThatDoesNotFit) {
  Bytes bytes(16, 0xEE);
  CdrWriter to{reinterpret_cast<std::byte*>(bytes.data()), 10};
  to.put(std::uint64_t{1});  // these 8 bytes exceed the buffer by two
  to.put(std::uint8_t{2});   // would fit, but follows a value that does not fit
  EXPECT_EQ(to.size(), 0U);
  EXPECT_EQ(bytes,
            (Bytes{0, 1, 0, 0, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE}));
}

TEST(CdrWriter, RejectsALengthThatExceedsItsBoundOr32Bits) {
  EXPECT_EQ(written([](CdrWriter& to) { to.put_length(4, 3); }), Bytes{});
  EXPECT_EQ(written([](CdrWriter& to) { to.put_length((1ULL << 32) + 1, 3); }), Bytes{});
}

TEST(CdrReader, ReadsBothByteOrders) {
  const Bytes little{0, 1, 0, 0, 1, 0, 2, 0, 3, 0, 0, 0, 0, 0, 0xC0, 0x3F};
  const Bytes big{0, 0, 0, 0, 0, 1, 0, 2, 0, 0, 0, 3, 0x3F, 0xC0, 0, 0};
  for (const Bytes& bytes : {little, big}) {
    CdrReader from = reader(bytes);
    std::array<std::int16_t, 2> two{};
    from.get_array(two.data(), two.size());
    EXPECT_EQ(two[0], 1);
    EXPECT_EQ(two[1], 2);
    EXPECT_EQ(from.get<std::uint32_t>(), 3U);
    EXPECT_EQ(from.get<float>(), 1.5F);
    EXPECT_TRUE(from.complete());
  }
}

TEST(CdrReader, ReturnsZerosAfterTheFirstError) {
  const Bytes bytes{0, 1, 0, 0, 7, 2, 9, 9};
  CdrReader from = reader(bytes);
  EXPECT_EQ(from.get<std::uint8_t>(), 7);
  EXPECT_FALSE(from.get_boolean());  // a byte with the value 2 is not a valid boolean
  EXPECT_FALSE(from.ok());
  EXPECT_EQ(from.get<std::uint8_t>(), 0);
  EXPECT_EQ(from.get_length(9), 0U);
  EXPECT_EQ(from.get_text(9), "");
  EXPECT_EQ(from.get_enumerator(9), 0U);
  EXPECT_EQ(from.take_array(1, 1), nullptr);
  std::array<char, 4> text{'x', 'x', 'x', 'x'};
  from.get_text(text.data(), 3);
  EXPECT_EQ(text[0], 0);
  EXPECT_FALSE(from.complete());
}

TEST(CdrReader, NeverReadsBeyondTheBuffer) {
  const Bytes bytes{0, 1, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 1, 2};
  EXPECT_EQ(reader(bytes).get_length(std::numeric_limits<std::uint32_t>::max()), 0U);
  EXPECT_EQ(reader(bytes).take_array(8, std::numeric_limits<std::size_t>::max() / 4), nullptr);
  EXPECT_EQ(reader(bytes).take_array(8, 1), nullptr);
  EXPECT_NE(reader(bytes).take_array(2, 3), nullptr);
  // Each element takes at least one byte. So a valid length is at most the number of bytes that follow it.
  EXPECT_EQ(reader({0, 1, 0, 0, 2, 0, 0, 0, 1, 2}).get_length(9), 2U);
  EXPECT_EQ(reader({0, 1, 0, 0, 3, 0, 0, 0, 1, 2}).get_length(9), 0U);
}

TEST(CdrReader, AcceptsOnlyAStringThatEndsAtItsLength) {
  const auto text = [](Bytes bytes) {
    bytes.insert(bytes.begin(), {0, 1, 0, 0});
    CdrReader from = reader(bytes);
    const std::string result{from.get_text(3)};
    return from.ok() ? result : "wrong";
  };
  EXPECT_EQ(text({4, 0, 0, 0, 'a', 'b', 'c', 0}), "abc");
  EXPECT_EQ(text({1, 0, 0, 0, 0}), "");
  EXPECT_EQ(text({0, 0, 0, 0}), "wrong");
  EXPECT_EQ(text({5, 0, 0, 0, 'a', 'b', 'c', 'd', 0}), "wrong");
  EXPECT_EQ(text({3, 0, 0, 0, 'a', 'b', 'c', 0}), "wrong");
  EXPECT_EQ(text({4, 0, 0, 0, 'a', 0, 'c', 0}), "wrong");
  EXPECT_EQ(text({4, 0, 0, 0, 'a', 'b', 'c'}), "wrong");
}

TEST(CdrReader, AcceptsUpToThreeBytesOfPaddingAtTheEnd) {
  for (std::size_t more = 0; more < 6; ++more) {
    Bytes bytes{0, 1, 0, 0, 7};
    bytes.resize(bytes.size() + more);
    CdrReader from = reader(bytes);
    EXPECT_EQ(from.get<std::uint8_t>(), 7);
    EXPECT_EQ(from.complete(), more < 4) << more;
  }
}

TEST(CdrReader, AcceptsOnlyPlainCdr) {
  for (int first = 0; first < 256; ++first) {
    for (int second = 0; second < 16; ++second) {
      const Bytes bytes{static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second), 0xAB, 0xCD};
      EXPECT_EQ(reader(bytes).complete(), first == 0 && second < 2);
    }
  }
  EXPECT_FALSE(reader({}).complete());
  EXPECT_FALSE(reader({0, 1, 0}).complete());
}

}  // namespace
}  // namespace takt::cdr_test
