#include <takt/wire/rtps.hpp>

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace takt::wire::rtps_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Builds the content of a submessage in little-endian byte order.
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
  Body& octets(const std::string& content) {
    u32(static_cast<std::uint32_t>(content.size()));
    bytes.insert(bytes.end(), content.begin(), content.end());
    return zeros((4 - content.size() % 4) % 4);
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

void append(Bytes& all, std::uint8_t kind, const Body& body, std::uint8_t flags = 0) {
  const Bytes one = message(kind, flags, body);
  all.insert(all.end(), one.begin() + 20, one.end());
}

constexpr std::uint8_t kSecBody = 0x30;
constexpr std::uint8_t kSecPrefix = 0x31;
constexpr std::uint8_t kSrtpsPrefix = 0x33;

bool is_rtps(const Bytes& bytes) { return !bytes.empty() && readable_rtps(bytes) == bytes.size(); }

/// Expects that the filter accepts a submessage with this content, and rejects it if any bytes are missing at
/// the end of the content.
void expect_minimum_length(std::uint8_t kind, std::uint8_t flags, const Body& body) {
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
Body discovery(const Body& parameters, std::uint32_t writer = 0x3c2) {
  return data_head(writer).u8(0).u8(3).u16(0).add(parameters).add(end_of_list());
}
/// The GUID of a participant.
const Body kGuid = parameter(0x50, Body{}.zeros(11).u8(1).id(0x1c1));
bool is_discovery(const Body& parameters) { return is_rtps(message(0x15, 4, discovery(parameters))); }

Body fragments(std::uint32_t first, std::uint32_t count, std::uint32_t size, std::uint32_t sample,
               std::size_t content, std::uint32_t to_qos = 28) {
  return data_head(0x103, 1, to_qos).u32(first).u16(count).u16(size).u32(sample).zeros(content);
}

TEST(RtpsFilter, RequiresAValidHeader) {
  const Bytes whole = message(0x01, 0, Body{});
  EXPECT_TRUE(is_rtps(whole));
  EXPECT_FALSE(is_rtps({}));
  Bytes other = header();
  other.pop_back();
  EXPECT_FALSE(is_rtps(other));
  for (std::size_t i = 0; i < 5; ++i) {
    other = whole;
    ++other[i];
    EXPECT_FALSE(is_rtps(other)) << i;
  }
}

// Fast DDS reads the first submessage of a message without checking that there is one.
TEST(RtpsFilter, RejectsAMessageWithoutASubmessage) {
  EXPECT_FALSE(is_rtps(header()));
  EXPECT_EQ(readable_rtps(message(0x80, 0, Body{}.zeros(56))), 0U) << "statistics are not passed on";
}

TEST(RtpsFilter, RejectsASubmessageThatExceedsTheMessage) {
  Bytes three = header();
  three.insert(three.end(), {0x01, 1, 0});
  EXPECT_FALSE(is_rtps(three));
  Bytes two = message(0x0e, 0, Body{}.zeros(12));
  const Bytes last = message(0x81, 0, Body{}.zeros(5));
  two.insert(two.end(), last.begin() + 20, last.end());
  EXPECT_TRUE(is_rtps(two)) << "submessages of vendors are skipped";
  two.pop_back();
  EXPECT_FALSE(is_rtps(two));
}

TEST(RtpsFilter, RemovesStatisticsAtTheEndOfAMessage) {
  const Bytes one = message(0x0e, 0, Body{}.zeros(12));
  const Bytes statistics = message(0x80, 0, Body{}.zeros(56));
  Bytes both = one;
  both.insert(both.end(), statistics.begin() + 20, statistics.end());
  EXPECT_EQ(readable_rtps(both), one.size());
  both.insert(both.end(), one.begin() + 20, one.end());
  EXPECT_EQ(readable_rtps(both), 0U) << "Fast DDS aborts if anything follows statistics";
}

// If the length of a submessage is not a multiple of four, Fast DDS expects the next submessage at the next
// multiple of four. A filter that continues right after the content would see other submessages.
TEST(RtpsFilter, LocatesSubmessagesAsFastDdsDoes) {
  Bytes both = message(0x81, 0, Body{}.zeros(5));
  // These bytes have two meanings. Read from the first byte, they are a vendor submessage of 128 bytes. Read
  // from the fourth byte, they are a statistics submessage that is not at the end of the message.
  for (const int byte : {0x81, 0, 0, 0x80, 0, 0, 44}) both.push_back(static_cast<std::uint8_t>(byte));
  both.resize(both.size() + 125);
  EXPECT_EQ(readable_rtps(both), 0U);
  Bytes padded = message(0x81, 0, Body{}.zeros(5));
  padded.resize(padded.size() + 3);
  const Bytes next = message(0x0e, 0, Body{}.zeros(12));
  padded.insert(padded.end(), next.begin() + 20, next.end());
  EXPECT_TRUE(is_rtps(padded));
}

TEST(RtpsFilter, LetsASubmessageWithoutALengthExtendToTheEnd) {
  Bytes open = message(0x07, 0, Body{}.zeros(8).number(1).number(1).u32(1));
  open[22] = 0;
  EXPECT_TRUE(is_rtps(open));
  open.pop_back();
  EXPECT_FALSE(is_rtps(open));
}

TEST(RtpsFilter, RequiresTheMinimumLengthOfEachSubmessage) {
  expect_minimum_length(0x06, 0, Body{}.zeros(8).number(0).u32(33).zeros(8).u32(1));
  expect_minimum_length(0x07, 0, Body{}.zeros(8).number(1).number(0).u32(1));
  expect_minimum_length(0x08, 0, Body{}.zeros(8).number(1).number(5).u32(256).zeros(32));
  expect_minimum_length(0x0c, 0, Body{}.zeros(20));
  expect_minimum_length(0x0d, 2, Body{}.zeros(16));
  expect_minimum_length(0x0e, 0, Body{}.zeros(12));
  expect_minimum_length(0x0f, 0, Body{}.u32(2).zeros(48));
  expect_minimum_length(0x12, 0, Body{}.zeros(8).number(1).u32(1).u32(1).zeros(4).u32(1));
  expect_minimum_length(0x13, 0, Body{}.zeros(8).number(1).u32(1).u32(1));
  expect_minimum_length(0x15, 0, data_head());
  expect_minimum_length(0x30, 0, Body{}.id(5).zeros(5));
  expect_minimum_length(0x31, 0, Body{}.zeros(20));
  expect_minimum_length(0x33, 0, Body{}.zeros(20));
  expect_minimum_length(0x34, 0, Body{}.zeros(16).id(1).zeros(20));
  EXPECT_TRUE(is_rtps(message(0x09, 2, Body{}))) << "an invalidated time stamp has no content";
}

TEST(RtpsFilter, RejectsInvalidSequenceNumbers) {
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(0).number(1).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(5).number(3).u32(1))))
      << "the last number is before the first";
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(1).number(-1).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x08, 0, Body{}.zeros(8).number(5).number(4).u32(0))));
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(kMin).number(kMin).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x06, 0, Body{}.zeros(8).number(1).u32(257).zeros(36).u32(1))))
      << "too many bits";
  EXPECT_FALSE(is_rtps(message(0x06, 0, Body{}.zeros(8).number(-1).u32(0).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x15, 0, data_head(0x103, 0))));
  EXPECT_FALSE(is_rtps(message(0x15, 0, data_head(0x103, 1, 15))))
      << "the offset points before the end of the header";
  EXPECT_FALSE(is_rtps(message(0x15, 0, data_head(0x103, 1, 17))))
      << "the offset points beyond the end of the header";
  EXPECT_FALSE(is_rtps(message(0x15, 0x0c, data_head().zeros(8)))) << "both a key and data";
  EXPECT_FALSE(is_rtps(message(0x0f, 0, Body{}.u32(0xffffffff).zeros(48))));
}

// Fast DDS adds small numbers to a sequence number without checking for an overflow.
TEST(RtpsFilter, RejectsSequenceNumbersThatCouldOverflow) {
  constexpr std::int64_t kMost = std::int64_t{1} << 62;
  EXPECT_TRUE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(kMost).number(kMost).u32(1))));
  EXPECT_FALSE(is_rtps(message(0x07, 0, Body{}.zeros(8).number(kMost + 1).number(kMost + 1).u32(1))));
  EXPECT_TRUE(is_rtps(message(0x08, 0, Body{}.zeros(8).number(1).number(kMost).u32(0))));
  EXPECT_FALSE(is_rtps(message(0x08, 0, Body{}.zeros(8).number(1).number(kMost + 1).u32(0))));
}

TEST(RtpsFilter, RejectsCountsOfItemsThatDoNotFollow) {
  constexpr std::uint32_t kRepresentations = 0x73;
  EXPECT_TRUE(is_discovery(parameter(kRepresentations, Body{}.u32(2).u16(0).u16(2))));
  EXPECT_TRUE(is_discovery(parameter(kRepresentations, Body{}.u32(0))));
  EXPECT_FALSE(is_discovery(parameter(kRepresentations, Body{}.u32(3).u16(0).u16(2))));
  EXPECT_FALSE(is_discovery(parameter(kRepresentations, Body{}.u32(0xffffffff).zeros(4))));
  EXPECT_FALSE(is_discovery(parameter(kRepresentations, Body{})));
  constexpr std::uint32_t kDataSharing = 0x8006;
  EXPECT_TRUE(is_discovery(parameter(kDataSharing, Body{}.u32(2).zeros(16))));
  EXPECT_TRUE(is_discovery(parameter(kDataSharing, Body{}.u32(0))));
  EXPECT_FALSE(is_discovery(parameter(kDataSharing, Body{}.u32(2).zeros(12))));
  EXPECT_FALSE(is_discovery(parameter(kDataSharing, Body{}.u32(0xffffffff).zeros(8))));
  EXPECT_FALSE(is_discovery(parameter(kDataSharing, Body{})));
}

TEST(RtpsFilter, RejectsAContentFilterLongerThanItsMessage) {
  const Body names = Body{}.text("filtered").text("topic").text("DDSSQL");
  const Body whole = Body{names}.text("x > %0").u32(2).text("1").text("2");
  EXPECT_TRUE(is_discovery(parameter(0x35, whole)));
  for (std::size_t n = 0; n < whole.bytes.size(); n += 4) {
    Body shorter = whole;
    shorter.bytes.resize(n);
    EXPECT_FALSE(is_discovery(parameter(0x35, shorter))) << n;
  }
  EXPECT_FALSE(is_discovery(parameter(0x35, Body{names}.u32(0xfffffff8).zeros(8))));
  EXPECT_FALSE(is_discovery(parameter(0x35, Body{names}.text("x > %0").u32(0xffffffff).zeros(8))));
}

// Fast DDS reads this offset as a signed number. If it is negative, Fast DDS looks for the content elsewhere
// than the filter does.
TEST(RtpsFilter, RejectsAnOffsetThatFastDdsReadsAsNegative) {
  for (const std::uint32_t offset : {0x7fffU, 0x8000U}) {
    EXPECT_EQ(is_rtps(message(0x15, 4, data_head(0x103, 1, offset).zeros(0x8000))), offset == 0x7fff);
    EXPECT_EQ(is_rtps(message(0x16, 0, fragments(1, 1, 8, 8, 0x8000, offset))), offset == 0x7fff);
  }
}

TEST(RtpsFilter, RejectsAParameterListWithoutAnEnd) {
  const Body hash = parameter(0x70, Body{}.zeros(16));
  EXPECT_TRUE(is_rtps(message(0x15, 2, data_head().add(hash).add(end_of_list()))));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head().add(hash))));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head())));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head().u16(0x70).u16(16).zeros(8))));
  EXPECT_FALSE(is_rtps(message(0x15, 2, data_head().u16(0x8000).u16(2).zeros(2).add(end_of_list()))));
  EXPECT_TRUE(is_discovery(parameter(0x8007, Body{}.zeros(4))));
  EXPECT_FALSE(is_rtps(message(0x15, 4, data_head(kSpdpWriter).u8(0).u8(3).u16(0))));
  EXPECT_FALSE(is_rtps(message(0x15, 4, data_head(kSpdpWriter).u8(0).u8(1).u16(0).add(end_of_list()))))
      << "discovery data is a parameter list";
  EXPECT_TRUE(is_rtps(message(0x15, 4, data_head().u8(0).u8(1).u16(0)))) << "other data is not";
}

TEST(RtpsFilter, RejectsAParameterLongerThanItsMessage) {
  const std::string name = "takt/device";
  for (const std::uint32_t which : {0x05U, 0x07U, 0x62U, 0x4005U}) {
    EXPECT_TRUE(is_discovery(parameter(which, Body{}.text(name))));
    EXPECT_FALSE(is_discovery(parameter(which, Body{}.u32(5).zeros(4))));
    EXPECT_FALSE(is_discovery(parameter(which, Body{}.u32(4).u32(0x61616161)))) << "without the final zero";
    EXPECT_FALSE(is_discovery(parameter(which, Body{})));
  }
  EXPECT_TRUE(is_discovery(parameter(0x29, Body{}.u32(2).text("a").text("bcdef"))));
  EXPECT_FALSE(is_discovery(parameter(0x29, Body{}.u32(3).text("a").text("bcdef"))));
  EXPECT_FALSE(is_discovery(parameter(0x29, Body{}.u32(0xffffffff))));
  EXPECT_FALSE(is_discovery(parameter(0x29, Body{}.u32(1).u32(0)))) << "a text without a final zero";
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

// Fast DDS allocates or copies as many bytes as a token claims to have, before it checks how many bytes there
// are.
TEST(RtpsFilter, RejectsATokenLongerThanItsMessage) {
  const Body all = Body{}.text("PKI").u32(1).text("name").text("value").u32(1).text("c.id").octets("abcde");
  for (const std::uint32_t which : {0x1001U, 0x1002U}) {
    EXPECT_TRUE(is_discovery(parameter(which, all)));
    EXPECT_TRUE(is_discovery(parameter(which, Body{}.text("").u32(0).u32(0))));
    for (std::size_t n = 0; n < all.bytes.size(); n += 4) {
      Body shorter = all;
      shorter.bytes.resize(n);
      EXPECT_FALSE(is_discovery(parameter(which, shorter))) << n;
    }
    for (const std::uint32_t many : {1000U, 0x40000000U, 0xfffffffcU, 0xffffffffU}) {
      EXPECT_FALSE(is_discovery(parameter(which, Body{}.u32(many).zeros(40))));
      EXPECT_FALSE(
          is_discovery(parameter(which, Body{}.text("PKI").u32(many).text("name").text("value").u32(0))));
      EXPECT_FALSE(
          is_discovery(parameter(which, Body{}.text("PKI").u32(0).u32(many).text("name").octets("v"))));
      EXPECT_FALSE(is_discovery(parameter(which, Body{}.text("PKI").u32(1).u32(many).zeros(40).u32(0))));
      EXPECT_FALSE(
          is_discovery(parameter(which, Body{}.text("PKI").u32(1).text("name").u32(many).zeros(40))));
      EXPECT_FALSE(
          is_discovery(parameter(which, Body{}.text("PKI").u32(0).u32(1).text("name").u32(many).zeros(4))));
    }
  }
}

constexpr std::uint32_t kProofWriter = 0x000201c3;

Body token(const std::string& name, const std::string& value) {
  return Body{}.text("DDS:Auth:PKI-DH:1.0+Req").u32(0).u32(1).text(name).octets(value);
}
Body proof(std::uint32_t tokens, const Body& content, std::uint32_t encapsulation = 1) {
  return data_head(kProofWriter)
      .u8(0)
      .u8(encapsulation)
      .u16(0)
      .zeros(96)
      .text("dds.sec.auth")
      .u32(tokens)
      .add(content);
}

TEST(RtpsFilter, RejectsAnIncompleteAuthenticationMessage) {
  const auto is_proof = [](const Body& body) { return is_rtps(message(0x15, 4, body)); };
  const Body one = token("c.id", "abc");
  EXPECT_TRUE(is_proof(proof(0, Body{})));
  EXPECT_TRUE(is_proof(proof(1, one)));
  EXPECT_TRUE(is_proof(proof(2, Body{one}.add(one))));
  EXPECT_FALSE(is_proof(proof(1, one, 0))) << "the other byte order";
  EXPECT_FALSE(is_proof(proof(1, one, 3))) << "a parameter list is not an authentication message";
  EXPECT_FALSE(is_proof(proof(2, one)));
  EXPECT_FALSE(is_proof(proof(0x20000000, one)));
  EXPECT_FALSE(is_proof(proof(1, Body{}.u32(0xfffffff0).zeros(60))));
  const Body whole = proof(1, one);
  for (std::size_t n = data_head().bytes.size() + 1; n < whole.bytes.size() - 1; ++n) {
    Body shorter = whole;
    shorter.bytes.resize(n);
    EXPECT_FALSE(is_proof(shorter)) << n;
  }
  Body unpadded = whole;
  unpadded.bytes.pop_back();
  EXPECT_TRUE(is_proof(unpadded)) << "the padding at the end may be missing";
}

TEST(RtpsFilter, ChecksTheCertificateOfAnAuthenticationMessage) {
  constexpr IsCertificate kIsPem = [](std::span<const std::uint8_t> bytes) noexcept {
    return std::string{bytes.begin(), bytes.end()} == "pem";
  };
  const auto readable = [&](const Body& tokens, std::uint32_t n) {
    return readable_rtps(message(0x15, 4, proof(n, tokens)), kIsPem) > 0;
  };
  EXPECT_TRUE(readable(token("c.id", "pem"), 1));
  EXPECT_FALSE(readable(token("c.id", "pen"), 1));
  EXPECT_TRUE(readable(token("c.perm", "pen"), 1));
  EXPECT_FALSE(readable(token("c.id", "pem").add(token("c.id", "")), 2)) << "each certificate is checked";
}

Body fragment_of(std::uint32_t writer, std::uint32_t sample) {
  return data_head(writer, 1, 28).u32(1).u16(1).u16(100).u32(sample).zeros(100);
}

TEST(RtpsFilter, RejectsFragmentsOfDiscoveryMessages) {
  for (const std::uint32_t writer : {kSpdpWriter, 0x2c2U, 0x3c2U, 0x4c2U})
    EXPECT_FALSE(is_rtps(message(0x16, 0, fragment_of(writer, 250)))) << writer;
}

TEST(RtpsFilter, LimitsTheSizeOfFragmentedAuthenticationMessages) {
  EXPECT_TRUE(is_rtps(message(0x16, 0, fragment_of(kProofWriter, 65535))));
  EXPECT_FALSE(is_rtps(message(0x16, 0, fragment_of(kProofWriter, 65536))));
  EXPECT_TRUE(is_rtps(message(0x16, 0, fragment_of(0x103, 65536)))) << "other samples may be larger";
}

TEST(RtpsFilter, ChecksAnAuthenticationMessageThatWasAssembled) {
  constexpr IsCertificate kIsPem = [](std::span<const std::uint8_t> bytes) noexcept {
    return std::string{bytes.begin(), bytes.end()} == "pem";
  };
  const auto content = [](const Body& message) {
    return Bytes{message.bytes.begin() + static_cast<std::ptrdiff_t>(data_head().bytes.size()),
                 message.bytes.end()};
  };
  const Bytes whole = content(proof(1, token("c.id", "pem")));
  EXPECT_TRUE(is_readable_proof(whole, kIsPem));
  EXPECT_TRUE(is_readable_proof(whole));
  EXPECT_FALSE(is_readable_proof(content(proof(1, token("c.id", "pen"))), kIsPem));
  EXPECT_FALSE(is_readable_proof(content(proof(1, token("c.id", "pem"), 0)))) << "the other byte order";
  EXPECT_FALSE(is_readable_proof(content(proof(1, token("c.id", "pem"), 3)))) << "a parameter list";
  for (std::size_t n = 0; n < whole.size() - 1; ++n)
    EXPECT_FALSE(is_readable_proof(std::span{whole}.first(n))) << n;
  // This content is readable in both byte orders.
  const auto encapsulated = [](std::uint8_t high, std::uint8_t low) {
    Bytes empty{high, low};
    empty.resize(4 + 96 + 4 + 4);
    return is_readable_proof(empty);
  };
  EXPECT_TRUE(encapsulated(0, 0) && encapsulated(0, 1));
  EXPECT_FALSE(encapsulated(0, 2));
  EXPECT_FALSE(encapsulated(1, 0));
}

// Fast DDS builds an object for each description of a type, however wrong, and parses a content filter
// recursively.
TEST(RtpsFilter, HidesParametersThatTaktDoesNotNeed) {
  const auto announcements = [](std::uint32_t writer, std::uint32_t which) {
    const Body list = Body{kGuid}
                          .add(parameter(0x05, Body{}.text("takt/device")))
                          .add(parameter(which, Body{}.u32(0xffffffff).zeros(40)))
                          .add(parameter(0x07, Body{}.text("takt::DeviceStatus")))
                          .add(parameter(which, Body{}));
    const Body inline_qos = parameter(0x70, Body{}.zeros(16)).add(end_of_list());
    const Body content = Body{}.u8(0).u8(3).u16(0).add(list).add(end_of_list());
    Bytes all = message(0x15, 4, data_head(writer).add(content));
    append(all, 0x09, Body{}.zeros(8));
    append(all, 0x15, data_head(writer).add(inline_qos).add(content), 6);
    return all;
  };
  for (const std::uint32_t writer : {kSpdpWriter, 0x3c2U, 0x4c2U}) {
    for (const std::uint32_t which : {0x69U, 0x72U, 0x75U, 0x4075U}) {
      Bytes sent = announcements(writer, which);
      ASSERT_TRUE(is_rtps(sent));
      skip_unused_parameters(sent);
      EXPECT_EQ(sent, announcements(writer, 0)) << which;
    }
    const Body filter = Body{}.text("f").text("t").text("DDSSQL").text(std::string(20000, '(')).u32(0);
    const auto filtered = [&](std::uint32_t which) {
      return message(0x15, 4, discovery(Body{kGuid}.add(parameter(which, filter)), writer));
    };
    Bytes sent = filtered(0x35);
    ASSERT_TRUE(is_rtps(sent));
    skip_unused_parameters(sent);
    EXPECT_EQ(sent, filtered(0));
  }
  const Bytes others = announcements(0x3c2, 0x8007);
  Bytes sent = others;
  skip_unused_parameters(sent);
  EXPECT_EQ(sent, others) << "other parameters stay";
  const Bytes sample = announcements(0x103, 0x75);
  sent = sample;
  skip_unused_parameters(sent);
  EXPECT_EQ(sent, sample) << "a sample stays as it is";
}

TEST(RtpsFilter, RejectsAnEncryptedContentLongerThanItsMessage) {
  for (const std::uint32_t size : {0xfffffff0U, 0xfffffff8U, 0xfffffffcU, 0xfffffffdU, 0xffffffffU}) {
    for (const std::uint8_t prefix : {kSecPrefix, kSrtpsPrefix}) {
      for (const std::size_t content : {0U, 4U, 64U}) {
        Bytes all = header();
        append(all, prefix, Body{}.zeros(20));
        append(all, kSecBody, Body{}.id(size).zeros(content));
        append(all, prefix + 1, Body{}.zeros(20));
        EXPECT_FALSE(is_rtps(all)) << size << ", " << content;
      }
    }
  }
}

// ---- Messages that DDS Security protects

/// Returns an encrypted message or submessage with an authentication code for each of `readers` readers.
Bytes encrypted(std::uint8_t prefix, std::uint32_t readers = 0) {
  Bytes all = header();
  append(all, prefix, Body{}.zeros(20));
  append(all, kSecBody, Body{}.id(5).zeros(5 + 3));
  append(all, prefix + 1, Body{}.zeros(16).id(readers).zeros(std::size_t{20} * readers));
  return all;
}
/// Returns true if the filter accepts the message, and if the whole message is protected.
bool is_protected(const Bytes& bytes) { return is_rtps(bytes) && is_protected_rtps(bytes); }
bool is_unprotected(const Bytes& bytes) { return is_rtps(bytes) && !is_protected_rtps(bytes); }

TEST(ProtectedRtps, MayBeEncryptedAsAWholeOrInEachSubmessage) {
  EXPECT_TRUE(is_protected(encrypted(kSrtpsPrefix)));
  EXPECT_TRUE(is_protected(encrypted(kSrtpsPrefix, 2)));
  EXPECT_TRUE(is_protected(encrypted(kSecPrefix)));
  Bytes two = message(0x0e, 0, Body{}.zeros(12));
  for (int i = 0; i < 2; ++i) {
    const Bytes one = encrypted(kSecPrefix, 1);
    two.insert(two.end(), one.begin() + 20, one.end());
  }
  append(two, 0x09, Body{}.zeros(8));
  EXPECT_TRUE(is_protected(two));
  EXPECT_TRUE(is_encrypted(two));
  EXPECT_TRUE(is_encrypted(encrypted(kSrtpsPrefix)));
  append(two, 0x07, Body{}.zeros(8).number(1).number(1).u32(1));
  EXPECT_TRUE(is_unprotected(two)) << "the last submessage is not encrypted";
}

TEST(ProtectedRtps, OnlyDiscoveryAndAuthenticationMayBeUnencrypted) {
  EXPECT_TRUE(is_protected(message(0x15, 4, discovery(kGuid, kSpdpWriter))));
  EXPECT_TRUE(is_protected(message(0x15, 4, proof(0, Body{}))));
  EXPECT_FALSE(is_encrypted(message(0x15, 4, proof(0, Body{}))));
  EXPECT_FALSE(is_encrypted(message(0x15, 4, discovery(kGuid, kSpdpWriter))));
  EXPECT_TRUE(is_protected(message(0x81, 0, Body{}.zeros(8)))) << "submessages of vendors are skipped";
  for (const std::uint32_t writer : {0x103U, 0x2c2U, 0x3c2U, 0x4c2U, 0x200c2U, 0xff0202c3U}) {
    EXPECT_FALSE(is_protected_rtps(message(0x15, 0, data_head(writer)))) << writer;
  }
  EXPECT_TRUE(is_protected(message(0x16, 0, fragment_of(kProofWriter, 250))));
  EXPECT_TRUE(is_unprotected(message(0x16, 0, fragments(1, 1, 100, 250, 100))));
  EXPECT_TRUE(is_unprotected(message(0x06, 0, Body{}.zeros(8).number(0).u32(0).u32(1))));
  EXPECT_TRUE(is_unprotected(message(0x07, 0, Body{}.zeros(8).number(1).number(1).u32(1))));
  EXPECT_TRUE(is_unprotected(message(0x08, 0, Body{}.zeros(8).number(1).number(5).u32(0))));
  EXPECT_TRUE(is_unprotected(message(0x12, 0, Body{}.zeros(8).number(1).u32(1).u32(1).zeros(4).u32(1))));
  EXPECT_TRUE(is_unprotected(message(0x13, 0, Body{}.zeros(8).number(1).u32(1).u32(1))));
  EXPECT_TRUE(is_unprotected(message(0x0f, 0, Body{}.u32(0)))) << "the submessage would redirect the replies";
}

// Fast DDS expects that each part begins where the previous part ends, and that it ends where its own content
// ends.
TEST(ProtectedRtps, MustHaveAllItsPartsInOrder) {
  const auto parts = [](std::uint8_t prefix, const Body& head, std::uint8_t kind, const Body& body,
                        std::uint8_t postfix, const Body& tail) {
    Bytes all = header();
    append(all, prefix, head);
    append(all, kind, body);
    append(all, postfix, tail);
    return all;
  };
  const Body head = Body{}.zeros(20);
  const Body body = Body{}.id(8).zeros(8);
  const Body tail = Body{}.zeros(20);
  const Body heartbeat = Body{}.zeros(8).number(1).number(1).u32(1);
  for (const std::uint8_t prefix : {kSecPrefix, kSrtpsPrefix}) {
    const auto postfix = static_cast<std::uint8_t>(prefix + 1);
    EXPECT_TRUE(is_protected(parts(prefix, head, kSecBody, body, postfix, tail)));
    EXPECT_TRUE(is_unprotected(parts(prefix, Body{head}.zeros(4), kSecBody, body, postfix, tail)));
    EXPECT_TRUE(is_unprotected(parts(prefix, head, 0x07, heartbeat, postfix, tail)))
        << "authenticated, not encrypted";
    EXPECT_TRUE(is_unprotected(parts(prefix, head, 0x81, body, postfix, tail))) << "nothing encrypted";
    EXPECT_TRUE(is_unprotected(parts(prefix, head, kSecBody, Body{body}.zeros(4), postfix, tail)));
    EXPECT_TRUE(is_unprotected(parts(prefix, head, kSecBody, body, postfix, Body{tail}.zeros(20))));
    EXPECT_TRUE(
        is_unprotected(parts(prefix, head, kSecBody, body, prefix == kSecPrefix ? 0x34 : 0x32, tail)));
    Bytes cut = header();
    append(cut, prefix, head);
    EXPECT_TRUE(is_unprotected(cut));
    append(cut, kSecBody, body);
    EXPECT_TRUE(is_unprotected(cut));
    Bytes open = parts(prefix, head, kSecBody, body, postfix, tail);
    open[open.size() - 22] = 0;  // sets the length of the last part to 0
    EXPECT_TRUE(is_unprotected(open));
  }
  Bytes more = encrypted(kSrtpsPrefix);
  append(more, 0x0e, Body{}.zeros(12));
  EXPECT_TRUE(is_unprotected(more)) << "content after a message that is encrypted as a whole";
  Bytes later = message(0x0e, 0, Body{}.zeros(12));
  const Bytes whole = encrypted(kSrtpsPrefix);
  later.insert(later.end(), whole.begin() + 20, whole.end());
  EXPECT_TRUE(is_unprotected(later)) << "Fast DDS decrypts it only at the beginning";
}

// ---- Announcements of participants

Bytes announcement(const Body& parameters, std::uint8_t flags = 4, const Body& inline_qos = {}) {
  return message(
      0x15, flags,
      data_head(kSpdpWriter).add(inline_qos).u8(0).u8(3).u16(0).add(parameters).add(end_of_list()));
}
/// The GUID of the participant that header() names as the sender.
const Body kSelf = parameter(0x50, Body{}.zeros(12).id(0x1c1));
const Body kLease = parameter(0x02, Body{}.u32(20).u32(0));

TEST(Announcement, MustComeFromTheAnnouncedParticipant) {
  using Of = Announcement::Of;
  const auto of = [](const Body& parameters) { return announcement_in(announcement(parameters)).of; };
  const Announcement one = announcement_in(announcement(Body{kSelf}.add(kLease)));
  EXPECT_EQ(one.of, Of::sender);
  EXPECT_EQ(one.lease_s, 20U);
  EXPECT_EQ(one.number, ParticipantNumber{});
  EXPECT_EQ(announcement_in(announcement(kSelf)).lease_s, ~0U) << "without a lease: for ever";
  EXPECT_EQ(of(kGuid), Of::other);
  EXPECT_EQ(of(Body{kSelf}.add(kGuid)), Of::other) << "two GUIDs, and Fast DDS might take either";
  EXPECT_EQ(of(Body{kSelf}.add(parameter(0x70, Body{}.zeros(11).u8(1).zeros(4)))), Of::other)
      << "the key hash differs";

  Bytes two = announcement(kSelf);
  append(two, 0x15, discovery(kSelf, kSpdpWriter), 4);
  EXPECT_EQ(announcement_in(two).of, Of::other) << "two announcements";
  EXPECT_EQ(announcement_in(header()).of, Of::nobody);
  EXPECT_EQ(announcement_in(message(0x15, 4, data_head().zeros(4))).of, Of::nobody);
}

// A discovery server passes on the announcements of others in the same message.
TEST(Announcement, AnnouncesOnlyTheAddressThatReplacesThoseOfItsParticipant) {
  using Address = std::array<std::uint8_t, 4>;
  const auto at = [](std::uint32_t kind, std::uint32_t port, const Address& address,
                     std::uint32_t which = 0x32) {
    Body locator = Body{}.u32(kind).u32(port).zeros(12);
    for (const std::uint8_t each : address) locator.u8(each);
    return parameter(which, locator);
  };
  const Address first{10, 0, 0, 1};
  const Address second{10, 0, 0, 2};
  const Address group{239, 255, 0, 1};
  const Body around = Body{at(1, 7400, group, 0x33)}.add(at(2, 7410, first)).add(at(1, 7411, first, 0x31));
  const auto announced = [&](const Body& guid, const Body& addresses) {
    return announcement(Body{guid}.add(around).add(addresses).add(kLease));
  };
  ParticipantNumber server{};  // that of kGuid
  server.back() = 1;
  const Body other = parameter(0x50, Body{}.zeros(11).u8(2).id(0x1c1));
  const Body before = Body{at(1, 11811, first)}.add(at(1, 11812, second));
  Bytes sent = announced(kGuid, before);
  Bytes expected = announced(kGuid, Body{at(1, 4660, {240, 0, 0, 1})}.add(at(1, 11812, second, 0)));
  append(sent, 0x15, discovery(Body{other}.add(before), kSpdpWriter), 4);
  append(expected, 0x15, discovery(Body{other}.add(before), kSpdpWriter), 4);
  append(sent, 0x15, discovery(Body{kGuid}.add(at(1, 11811, second)), kSpdpWriter), 4);
  append(expected, 0x15, discovery(Body{kGuid}.add(at(1, 4660, {240, 0, 0, 1})), kSpdpWriter), 4);
  ASSERT_TRUE(is_rtps(sent));
  EXPECT_EQ(replace_addresses(sent, server, {240, 0, 0, 1}, 4660), (std::vector{first, second, second}));
  EXPECT_EQ(sent, expected);

  Bytes others = announced(other, before);
  EXPECT_TRUE(replace_addresses(others, server, {240, 0, 0, 1}, 4660).empty());
  EXPECT_EQ(others, announced(other, before));

  const auto reversed = [&](const Body& locator) {
    const Body list =
        Body{}.u8(0).u8(0x50).u8(0).u8(16).zeros(11).u8(1).id(0x1c1).u8(0).u8(0x32).u8(0).u8(24).add(locator);
    return message(0x15, 4, data_head(kSpdpWriter).u8(0).u8(2).u16(0).add(list).u8(0).u8(1).u16(0));
  };
  sent = reversed(Body{}.id(1).id(11811).zeros(12).id(0x0a000001));
  ASSERT_TRUE(is_rtps(sent));
  EXPECT_EQ(replace_addresses(sent, server, {240, 0, 0, 1}, 4660), std::vector{first});
  EXPECT_EQ(sent, reversed(Body{}.id(1).id(4660).zeros(12).id(0xf0000001)));
}

TEST(LossReport, NamesWhoHasLostWhom) {
  const ParticipantNumber robot{1, 15, 1};
  const ParticipantNumber line{1, 15, 2};
  const LossReport report = loss_report(line, robot);
  EXPECT_TRUE(is_loss_report(report, robot));
  EXPECT_FALSE(is_loss_report(report, line));
  EXPECT_EQ(sender_of(report), line);
  for (std::size_t i = 0; i < report.size(); ++i) {
    LossReport other = report;
    other[i] ^= 1U;
    EXPECT_EQ(is_loss_report(other, robot), i >= 8 && i < 20) << "byte " << i;  // the sender
    EXPECT_FALSE(is_loss_report(std::span{report}.first(i), robot));
  }
}

TEST(Announcement, ContainsAVersionIfTheParticipantHasFastDds3) {
  const Body version = parameter(0x8000, Body{}.u8(3).u8(1).u8(2).u8(0));
  EXPECT_TRUE(announcement_in(announcement(Body{kSelf}.add(version))).has_version);
  EXPECT_FALSE(announcement_in(announcement(Body{kSelf}.add(kLease))).has_version);
}

TEST(Announcement, ContainsTheNameAndTheIdentityOfTheParticipant) {
  const Body identity = Body{}
                            .text("DDS:Auth:PKI-DH:1.0")
                            .u32(3)
                            .text("dds.cert.sn")
                            .text("/O=cell/OU=device/CN=robot")
                            .text("dds.cert.algo")
                            .text("EC-prime256v1")
                            .text("dds.ca.sn")
                            .text("/O=cell/CN=authority")
                            .u32(0);
  const Body name = parameter(0x62, Body{}.text("robot"));
  const Bytes named = announcement(Body{kSelf}.add(name).add(parameter(0x1001, identity)));
  const Announcement one = announcement_in(named);
  EXPECT_EQ(one.name, "robot");
  EXPECT_EQ(one.subject, "/O=cell/OU=device/CN=robot");
  EXPECT_EQ(one.authority, "/O=cell/CN=authority");

  const Bytes nameless = announcement(kSelf);
  EXPECT_EQ(announcement_in(nameless).name, "");
  EXPECT_EQ(announcement_in(nameless).subject, "");
  EXPECT_EQ(announcement_in(nameless).authority, "");
}

// Fast DDS may add a participant even when it receives a message that says that the participant leaves. So
// each message with participant data counts as an announcement.
TEST(Announcement, MayAlsoSayThatItsParticipantLeaves) {
  for (const std::uint32_t flags : {0U, 3U, 4U}) {
    const Body status = parameter(0x71, Body{}.id(flags)).add(end_of_list());
    EXPECT_EQ(announcement_in(announcement(kSelf, 6, status)).of, Announcement::Of::sender) << flags;
  }
  EXPECT_EQ(announcement_in(announcement(kSelf, 8)).of, Announcement::Of::nobody) << "only a key";
}

TEST(ConcernsParticipants, IsTrueForAnnouncementsAndFarewells) {
  EXPECT_TRUE(concerns_participants(announcement(kSelf)));
  EXPECT_TRUE(concerns_participants(announcement(kSelf, 8))) << "only a key: the participant leaves";
  EXPECT_FALSE(concerns_participants(header()));
  EXPECT_FALSE(concerns_participants(message(0x15, 4, data_head().zeros(4)))) << "data of another writer";
  Bytes second = message(0x15, 4, data_head().zeros(4));
  append(second, 0x15, discovery(kSelf, kSpdpWriter), 4);
  EXPECT_TRUE(concerns_participants(second)) << "in the second submessage";
}

TEST(Announcement, IsReadAsFastDdsReadsIt) {
  const Body other_lease = parameter(0x4002, Body{}.u32(5).u32(0));
  EXPECT_EQ(announcement_in(announcement(Body{kSelf}.add(kLease).add(other_lease))).lease_s, 20U);
}

// Fast DDS would accept the participant, and later fail an assertion.
TEST(RtpsFilter, RejectsAnAnnouncementWithoutTheGuidOfAParticipant) {
  const Body nobody = parameter(0x50, Body{}.zeros(12).id(0x1c1));
  const Body hash = parameter(0x70, Body{}.zeros(11).u8(1).id(0x1c1));
  const auto is_accepted = [](const Body& parameters) { return is_rtps(announcement(parameters)); };
  EXPECT_TRUE(is_accepted(Body{kLease}.add(kGuid)));
  EXPECT_TRUE(is_accepted(Body{kGuid}.add(hash)));
  EXPECT_FALSE(is_accepted(kLease));
  EXPECT_FALSE(is_accepted(hash));
  EXPECT_FALSE(is_accepted(parameter(0x4050, Body{}.zeros(11).u8(1).id(0x1c1)))) << "Fast DDS ignores it";
  EXPECT_FALSE(is_accepted(nobody));
  EXPECT_FALSE(is_accepted(Body{kGuid}.add(nobody))) << "the last one counts";
  EXPECT_FALSE(is_accepted(Body{kGuid}.add(parameter(0x70, Body{}.zeros(16)))));
  EXPECT_TRUE(is_rtps(announcement(kLease, 8))) << "only a key: the participant leaves";
}

TEST(RtpsFilter, RejectsFragmentsOutsideTheirSampleOrWithoutContent) {
  const auto fits = [](const Body& body) { return is_rtps(message(0x16, 0, body)); };
  EXPECT_TRUE(fits(fragments(1, 1, 100, 250, 100)));
  EXPECT_TRUE(fits(fragments(2, 2, 100, 250, 150)));
  EXPECT_FALSE(fits(fragments(2, 2, 100, 250, 149)));
  EXPECT_FALSE(fits(fragments(1, 1, 100, 250, 0))) << "without content";
  EXPECT_FALSE(fits(fragments(0, 1, 100, 250, 100)));
  EXPECT_FALSE(fits(fragments(1, 0, 100, 250, 100)));
  EXPECT_FALSE(fits(fragments(1, 1, 0, 250, 100)));
  EXPECT_FALSE(fits(fragments(1, 1, 100, 0, 100)));
  EXPECT_FALSE(fits(fragments(4, 1, 100, 250, 100))) << "there are only three fragments";
  EXPECT_FALSE(fits(fragments(3, 2, 100, 250, 200)));
  EXPECT_FALSE(fits(fragments(1, 1, 100, 250, 100, 16)));
  EXPECT_FALSE(is_rtps(message(0x16, 4, fragments(1, 1, 100, 250, 100)))) << "fragments of a key";
  EXPECT_FALSE(fits(fragments(0xffffffff, 0xffff, 0xffff, 0xffffffff, 100)));
}

TEST(RtpsFilter, RejectsRequestsWithOverflowingFragmentNumbers) {
  const auto request = [](std::uint32_t base) {
    return is_rtps(message(0x12, 0, Body{}.zeros(8).number(1).u32(base).u32(1).zeros(4).u32(1)));
  };
  EXPECT_FALSE(request(0));
  EXPECT_TRUE(request(0xffffffff - 256));
  EXPECT_FALSE(request(0xffffffff - 255));
}

TEST(RtpsFilter, ReadsBothByteOrders) {
  Bytes big = header();
  const std::vector<std::uint8_t> heartbeat{0x07, 0, 0, 28, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                                            0,    0, 0, 1,  0, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 1};
  big.insert(big.end(), heartbeat.begin(), heartbeat.end());
  EXPECT_TRUE(is_rtps(big));
  big[21] = 1;
  EXPECT_FALSE(is_rtps(big));
}

}  // namespace
}  // namespace takt::wire::rtps_test
