#include <takt/dds/rtps.hpp>

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace takt::dds {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Of numbers, little endian.
class Body {
 public:
  Body& u8(std::uint32_t value) { return put(value, 1); }
  Body& u16(std::uint32_t value) { return put(value, 2); }
  Body& u32(std::uint32_t value) { return put(value, 4); }
  Body& id(std::uint32_t value) { return u8(value >> 24U).u8(value >> 16U).u8(value >> 8U).u8(value); }
  Body& number(std::int64_t value) {
    return u32(static_cast<std::uint32_t>(value >> 32)).u32(static_cast<std::uint32_t>(value));
  }
  Body& zeros(std::size_t n) {
    bytes.resize(bytes.size() + n);
    return *this;
  }
  Body& text(const std::string& characters) {
    u32(static_cast<std::uint32_t>(characters.size() + 1));
    bytes.insert(bytes.end(), characters.begin(), characters.end());
    return zeros(1 + (3 - characters.size() % 4));
  }
  Body& add(const Body& other) {
    bytes.insert(bytes.end(), other.bytes.begin(), other.bytes.end());
    return *this;
  }
  Bytes bytes;

 private:
  Body& put(std::uint32_t value, int n) {
    for (int i = 0; i < n; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
    return *this;
  }
};

Bytes header() {
  Bytes message{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  message.resize(20);
  return message;
}

Bytes message(std::uint8_t kind, std::uint8_t flags, const Body& body) {
  Bytes all = header();
  const Body head = Body{}.u8(kind).u8(flags | 1U).u16(static_cast<std::uint32_t>(body.bytes.size()));
  all.insert(all.end(), head.bytes.begin(), head.bytes.end());
  all.insert(all.end(), body.bytes.begin(), body.bytes.end());
  return all;
}

bool is_rtps(const Bytes& bytes) { return !bytes.empty() && readable_rtps(bytes) == bytes.size(); }

/// As it is, and of no shorter length.
void is_just_long_enough(std::uint8_t kind, std::uint8_t flags, const Body& body) {
  EXPECT_TRUE(is_rtps(message(kind, flags, body))) << "kind " << int{kind};
  for (std::size_t n = 1; n < body.bytes.size(); ++n) {
    Body shorter = body;
    shorter.bytes.resize(n);
    EXPECT_FALSE(is_rtps(message(kind, flags, shorter))) << "kind " << int{kind} << ", " << n << " bytes";
  }
}

constexpr std::uint32_t kSpdpWriter = 0x000100c2;

Body data_head(std::uint32_t writer = 0x103, std::int64_t number = 1, std::uint32_t to_qos = 16) {
  return Body{}.u16(0).u16(to_qos).id(0).id(writer).number(number);
}
Body end_of_list() { return Body{}.u16(1).u16(0); }
Body parameter(std::uint32_t which, const Body& value) {
  return Body{}.u16(which).u16(static_cast<std::uint32_t>(value.bytes.size())).add(value);
}
Body discovery(const Body& parameters) {
  return data_head(kSpdpWriter).u8(0).u8(3).u16(0).add(parameters).add(end_of_list());
}
bool is_discovery(const Body& parameters) { return is_rtps(message(0x15, 4, discovery(parameters))); }

TEST(Rtps, BeginsWithItsHeader) {
  EXPECT_TRUE(is_rtps(header()));
  EXPECT_FALSE(is_rtps({}));
  Bytes other = header();
  other.pop_back();
  EXPECT_FALSE(is_rtps(other));
  for (std::size_t i = 0; i < 5; ++i) {
    other = header();
    ++other[i];
    EXPECT_FALSE(is_rtps(other)) << i;
  }
}

TEST(Rtps, ASubmessageLiesWithinItsMessage) {
  Bytes three = header();
  three.insert(three.end(), {0x01, 1, 0});
  EXPECT_FALSE(is_rtps(three));
  Bytes two = message(0x0e, 0, Body{}.zeros(12));
  const Bytes last = message(0x81, 0, Body{}.zeros(5));
  two.insert(two.end(), last.begin() + 20, last.end());
  EXPECT_TRUE(is_rtps(two)) << "one of a vendor is skipped";
  two.pop_back();
  EXPECT_FALSE(is_rtps(two));
}

TEST(Rtps, StatisticsAtTheEndAreNotRead) {
  const Bytes one = message(0x0e, 0, Body{}.zeros(12));
  const Bytes statistics = message(0x80, 0, Body{}.zeros(56));
  Bytes both = one;
  both.insert(both.end(), statistics.begin() + 20, statistics.end());
  EXPECT_EQ(readable_rtps(both), one.size());
  EXPECT_EQ(readable_rtps(statistics), header().size());
  both.insert(both.end(), one.begin() + 20, one.end());
  EXPECT_EQ(readable_rtps(both), 0U) << "Fast DDS breaks off where something is behind them";
}

// Where a length is no multiple of four, what lies behind it is another submessage for who goes on exactly
// there.
TEST(Rtps, IsReadWhereFastDdsReads) {
  Bytes both = message(0x81, 0, Body{}.zeros(5));
  // From here on one of a vendor of 128 bytes; a byte later, statistics that are not at the end.
  for (const int byte : {0x81, 0, 0, 0x80, 0, 0, 44}) both.push_back(static_cast<std::uint8_t>(byte));
  both.resize(both.size() + 125);
  EXPECT_EQ(readable_rtps(both), 0U);
  Bytes padded = message(0x81, 0, Body{}.zeros(5));
  padded.resize(padded.size() + 3);
  const Bytes next = message(0x0e, 0, Body{}.zeros(12));
  padded.insert(padded.end(), next.begin() + 20, next.end());
  EXPECT_TRUE(is_rtps(padded));
}

TEST(Rtps, OneWithoutALengthIsWhatIsLeft) {
  Bytes open = message(0x07, 0, Body{}.zeros(8).number(1).number(1).u32(1));
  open[22] = 0;
  EXPECT_TRUE(is_rtps(open));
  open.pop_back();
  EXPECT_FALSE(is_rtps(open));
}

TEST(Rtps, EachKindHasWhatItMust) {
  is_just_long_enough(0x06, 0, Body{}.zeros(8).number(0).u32(33).zeros(8).u32(1));
  is_just_long_enough(0x07, 0, Body{}.zeros(8).number(1).number(0).u32(1));
  is_just_long_enough(0x08, 0, Body{}.zeros(8).number(1).number(5).u32(256).zeros(32));
  is_just_long_enough(0x0c, 0, Body{}.zeros(20));
  is_just_long_enough(0x0d, 2, Body{}.zeros(16));
  is_just_long_enough(0x0e, 0, Body{}.zeros(12));
  is_just_long_enough(0x0f, 0, Body{}.u32(2).zeros(48));
  is_just_long_enough(0x12, 0, Body{}.zeros(8).number(1).u32(1).u32(1).zeros(4).u32(1));
  is_just_long_enough(0x13, 0, Body{}.zeros(8).number(1).u32(1).u32(1));
  is_just_long_enough(0x15, 0, data_head());
  is_just_long_enough(0x30, 0, Body{}.id(5).zeros(5));
  is_just_long_enough(0x31, 0, Body{}.zeros(20));
  is_just_long_enough(0x33, 0, Body{}.zeros(20));
  is_just_long_enough(0x34, 0, Body{}.zeros(16).id(1).zeros(20));
  EXPECT_TRUE(is_rtps(message(0x09, 2, Body{}))) << "a time stamp that is taken back";
}

TEST(Rtps, NumbersAreSound) {
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(0).number(1).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(5).number(3).u32(1))))
      << "the last before the first";
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(1).number(-1).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x08, 0, Body{}.zeros(8).number(5).number(4).u32(0))));
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(kMin).number(kMin).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x06, 0, Body{}.zeros(8).number(1).u32(257).zeros(36).u32(1)))) << "bits";
  EXPECT_FALSE(is_rtps(message(0x06, 0, Body{}.zeros(8).number(-1).u32(0).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x15, 0, data_head(0x103, 0))));
  EXPECT_FALSE(is_rtps(message(0x15, 0, data_head(0x103, 1, 15)))) << "into what is before it";
  EXPECT_FALSE(is_rtps(message(0x15, 0, data_head(0x103, 1, 17)))) << "beyond its end";
  EXPECT_FALSE(is_rtps(message(0x15, 0x0c, data_head().zeros(8)))) << "a key and data";
  EXPECT_FALSE(is_rtps(message(0x0f, 0, Body{}.u32(0xffffffff).zeros(48))));
}

TEST(Rtps, AListOfParametersEnds) {
  const Body hash = parameter(0x70, Body{}.zeros(16));
  EXPECT_TRUE(is_rtps(message(0x15, 2, data_head().add(hash).add(end_of_list()))));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head().add(hash))));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head())));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head().u16(0x70).u16(16).zeros(8))));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head().u16(0x8000).u16(2).zeros(2).add(end_of_list()))));
  EXPECT_TRUE(is_discovery(parameter(0x8007, Body{}.zeros(4))));
  EXPECT_FALSE(is_rtps(message(0x15, 4, data_head(kSpdpWriter).u8(0).u8(3).u16(0))));
  EXPECT_FALSE(is_rtps(message(0x15, 4, data_head(kSpdpWriter).u8(0).u8(1).u16(0).add(end_of_list()))))
      << "what tells of participants is a list";
  EXPECT_TRUE(is_rtps(message(0x15, 4, data_head().u8(0).u8(1).u16(0)))) << "and what else is sent is not";
}

TEST(Rtps, WhatAParameterCountsIsThere) {
  const std::string name = "takt/device";
  for (const std::uint32_t which : {0x05U, 0x07U, 0x62U, 0x4005U}) {
    EXPECT_TRUE(is_discovery(parameter(which, Body{}.text(name))));
    EXPECT_FALSE(is_discovery(parameter(which, Body{}.u32(5).zeros(4))));
    EXPECT_FALSE(is_discovery(parameter(which, Body{}.u32(4).u32(0x61616161)))) << "without its end";
    EXPECT_FALSE(is_discovery(parameter(which, Body{})));
  }
  EXPECT_TRUE(is_discovery(parameter(0x29, Body{}.u32(2).text("a").text("bcdef"))));
  EXPECT_FALSE(is_discovery(parameter(0x29, Body{}.u32(3).text("a").text("bcdef"))));
  EXPECT_FALSE(is_discovery(parameter(0x29, Body{}.u32(0xffffffff))));
  const Body one = Body{}.u32(1).text("name").text("value");
  EXPECT_TRUE(is_discovery(parameter(0x59, one)));
  EXPECT_TRUE(is_discovery(parameter(0x59, Body{one}.u32(1).text("name").u32(3).zeros(4))));
  EXPECT_FALSE(is_discovery(parameter(0x59, Body{}.u32(2).text("name").text("value"))));
  EXPECT_FALSE(is_discovery(parameter(0x59, Body{one}.u32(1).text("name").u32(9).zeros(4))));
  EXPECT_TRUE(is_discovery(parameter(0x2c, Body{}.u32(3).zeros(4))));
  EXPECT_FALSE(is_discovery(parameter(0x2c, Body{}.u32(5).zeros(4))));
  EXPECT_TRUE(is_discovery(parameter(0x31, Body{}.zeros(24))));
  EXPECT_FALSE(is_discovery(parameter(0x31, Body{}.zeros(20))));
  EXPECT_FALSE(is_discovery(parameter(0x50, Body{}.zeros(12))));
  EXPECT_FALSE(is_discovery(parameter(0x58, Body{}.zeros(8))));
}

Body fragments(std::uint32_t first, std::uint32_t count, std::uint32_t size, std::uint32_t sample,
               std::size_t content, std::uint32_t to_qos = 28) {
  return data_head(0x103, 1, to_qos).u32(first).u16(count).u16(size).u32(sample).zeros(content);
}

TEST(Rtps, FragmentsLieInTheirSampleAndAreThere) {
  const auto fits = [](const Body& body) { return is_rtps(message(0x16, 0, body)); };
  EXPECT_TRUE(fits(fragments(1, 1, 100, 250, 100)));
  EXPECT_TRUE(fits(fragments(2, 2, 100, 250, 150)));
  EXPECT_FALSE(fits(fragments(2, 2, 100, 250, 149)));
  EXPECT_FALSE(fits(fragments(1, 1, 100, 250, 0))) << "without content";
  EXPECT_FALSE(fits(fragments(0, 1, 100, 250, 100)));
  EXPECT_FALSE(fits(fragments(1, 0, 100, 250, 100)));
  EXPECT_FALSE(fits(fragments(1, 1, 0, 250, 100)));
  EXPECT_FALSE(fits(fragments(1, 1, 100, 0, 100)));
  EXPECT_FALSE(fits(fragments(4, 1, 100, 250, 100))) << "there are three";
  EXPECT_FALSE(fits(fragments(3, 2, 100, 250, 200)));
  EXPECT_FALSE(fits(fragments(1, 1, 100, 250, 100, 16)));
  EXPECT_FALSE(fits(fragments(0xffffffff, 0xffff, 0xffff, 0xffffffff, 100)));
}

TEST(Rtps, BothByteOrdersAreRead) {
  Bytes big = header();
  const std::vector<std::uint8_t> heartbeat{0x07, 0, 0, 28, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                            0,    0, 0, 1,  0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 1};
  big.insert(big.end(), heartbeat.begin(), heartbeat.end());
  EXPECT_TRUE(is_rtps(big));
  big[21] = 1;
  EXPECT_FALSE(is_rtps(big));
}

}  // namespace
}  // namespace takt::dds
