#include <takt/dds/rtps.hpp>

#include <algorithm>
#include <array>

namespace takt::dds {

namespace {

constexpr std::size_t kHeader = 20;
constexpr std::uint32_t kMostBits = 256;  // of a set of sequence numbers or fragments
constexpr std::int64_t kMostNumber = std::int64_t{1} << 62;

/// From begin to end, in one byte order. After the first thing that is missing everything is 0.
class Cursor {
 public:
  Cursor(std::span<const std::uint8_t> bytes, bool little) noexcept : left_(bytes), little_(little) {}

  [[nodiscard]] bool ok() const noexcept { return ok_; }
  [[nodiscard]] std::size_t left() const noexcept { return left_.size(); }
  void fail() noexcept {
    ok_ = false;
    left_ = {};
  }
  std::span<const std::uint8_t> bytes(std::size_t n) noexcept {
    if (n > left_.size()) {
      fail();
      return {};
    }
    const auto taken = left_.first(n);
    left_ = left_.subspan(n);
    return taken;
  }
  void skip(std::size_t n) noexcept { static_cast<void>(bytes(n)); }
  std::uint32_t u16() noexcept { return number(2); }
  std::uint32_t u32() noexcept { return number(4); }
  /// Of an entity: always in this order.
  std::uint32_t id() noexcept {
    std::uint32_t value = 0;
    for (const std::uint8_t byte : bytes(4)) value = value << 8U | byte;
    return value;
  }
  /// A sequence number, which is at least `least`.
  std::int64_t sequence(std::int64_t least) noexcept {
    const auto high = static_cast<std::int32_t>(u32());
    const std::int64_t value = static_cast<std::int64_t>(high) * (std::int64_t{1} << 32) + u32();
    if (value >= least && value <= kMostNumber) return value;
    fail();
    return least;
  }
  /// The bits of a set, after its base.
  void bits() noexcept {
    const std::uint32_t n = u32();
    if (n > kMostBits) return fail();
    skip((n + 31) / 32 * 4);
  }
  /// A CDR string: its length, and a zero at its end.
  void text() noexcept {
    const std::uint32_t size = u32();
    const auto characters = bytes(size);
    if (size > 0 && (characters.empty() || characters.back() != 0)) return fail();
    align();
  }
  void octets() noexcept {
    skip(u32());
    align();
  }
  void align() noexcept { skip(std::min<std::size_t>(left_.size() % 4, left_.size())); }
  [[nodiscard]] bool little() const noexcept { return little_; }
  [[nodiscard]] Cursor part(std::size_t n) noexcept { return {bytes(n), little_}; }

 private:
  std::uint32_t number(std::size_t n) noexcept {
    const auto taken = bytes(n);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < taken.size(); ++i)
      value |= std::uint32_t{taken[i]} << 8U * (little_ ? i : taken.size() - 1 - i);
    return value;
  }

  std::span<const std::uint8_t> left_;
  bool little_;
  bool ok_ = true;
};

// ---- Lists of parameters

enum class Content { any, text, texts, properties, octets, locator, guid, number };

Content content_of(std::uint32_t parameter) noexcept {
  constexpr std::uint32_t kMustUnderstand = 0x4000;
  switch (parameter & ~kMustUnderstand) {
    case 0x05:  // topic name
    case 0x07:  // type name
    case 0x62:  // entity name
      return Content::text;
    case 0x29:  // partition
      return Content::texts;
    case 0x59:
      return Content::properties;
    case 0x2c:  // user, group and topic data
    case 0x2d:
    case 0x2e:
      return Content::octets;
    case 0x2f:  // of endpoints and participants, unicast and multicast
    case 0x30:
    case 0x31:
    case 0x32:
    case 0x33:
    case 0x48:
      return Content::locator;
    case 0x50:  // of a participant, an endpoint, a group
    case 0x52:
    case 0x5a:
    case 0x70:  // hash of a key
      return Content::guid;
    case 0x58:  // built-in endpoints
    case 0x71:  // disposed, unregistered
    case 0x77:
      return Content::number;
    default:
      return Content::any;
  }
}

void check_properties(Cursor& value) noexcept {
  for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n) {
    value.text();
    value.text();
  }
  // Those with bytes for a value may follow.
  if (value.left() < 4) return;
  for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n) {
    value.text();
    value.octets();
  }
}

bool is_parameter(std::uint32_t parameter, Cursor value) noexcept {
  switch (content_of(parameter)) {
    case Content::any:
      break;
    case Content::text:
      value.text();
      break;
    case Content::texts:
      for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n) value.text();
      break;
    case Content::properties:
      check_properties(value);
      break;
    case Content::octets:
      value.octets();
      break;
    case Content::locator:
      return value.left() == 24;
    case Content::guid:
      return value.left() == 16;
    case Content::number:
      return value.left() == 4;
  }
  return value.ok();
}

/// Up to and with its end.
void check_parameters(Cursor& list) noexcept {
  constexpr std::uint32_t kPad = 0;
  constexpr std::uint32_t kEnd = 1;
  while (list.ok()) {
    const std::uint32_t parameter = list.u16();
    const std::uint32_t size = list.u16();
    if (parameter == kEnd || !list.ok()) return;
    if (size % 4 != 0 || size > list.left()) return list.fail();
    Cursor value = list.part(size);
    if (parameter != kPad && !is_parameter(parameter, value)) return list.fail();
  }
}

// ---- Submessages

/// Those that tell of participants, readers and writers, whose content is a list of parameters.
bool discovers(std::uint32_t writer) noexcept {
  return writer == 0x000100c2 || writer == 0x000002c2 || writer == 0x000003c2 || writer == 0x000004c2;
}

constexpr std::uint8_t kLittle = 1;
constexpr std::uint8_t kInlineQos = 2;

/// The two lengths and ids with which DATA and DATA_FRAG begin, and the number; the writer.
std::uint32_t check_head(Cursor& body, std::uint32_t behind) noexcept {
  body.skip(2);
  const std::uint32_t to_qos = body.u16();  // from here on
  body.skip(4);
  const std::uint32_t writer = body.id();
  static_cast<void>(body.sequence(1));
  if (to_qos < behind || to_qos > behind + body.left()) body.fail();
  return writer;
}

void check_data(Cursor& body, std::uint8_t flags) noexcept {
  constexpr std::uint8_t kData = 4;
  constexpr std::uint8_t kKey = 8;
  constexpr std::uint32_t kBehind = 16;
  Cursor copy = body;
  copy.skip(2);
  const std::uint32_t to_qos = copy.u16();
  const std::uint32_t writer = check_head(body, kBehind);
  if (!body.ok()) return;
  body.skip(to_qos - kBehind);
  if ((flags & kInlineQos) != 0) check_parameters(body);
  if ((flags & kData) != 0 && (flags & kKey) != 0) return body.fail();
  if ((flags & (kData | kKey)) == 0) return;
  const auto encapsulation = body.bytes(4);
  if (!body.ok() || !discovers(writer)) return;
  // PL_CDR, and its byte order.
  if (encapsulation[0] != 0 || (encapsulation[1] != 2 && encapsulation[1] != 3)) return body.fail();
  Cursor list{body.bytes(body.left()), encapsulation[1] == 3};
  check_parameters(list);
  if (!list.ok()) body.fail();
}

void check_fragments(Cursor& body, std::uint8_t flags) noexcept {
  constexpr std::uint32_t kBehind = 28;
  Cursor copy = body;
  copy.skip(2);
  const std::uint32_t to_qos = copy.u16();
  static_cast<void>(check_head(body, 16));
  const std::uint64_t first = body.u32();
  const std::uint64_t count = body.u16();
  const std::uint64_t size = body.u16();
  const std::uint64_t sample = body.u32();
  if (!body.ok() || to_qos < kBehind || first == 0 || count == 0 || size == 0 || sample == 0)
    return body.fail();
  body.skip(to_qos - kBehind);
  if ((flags & kInlineQos) != 0) check_parameters(body);
  const std::uint64_t begin = (first - 1) * size;
  if (begin >= sample || begin + (count - 1) * size >= sample) return body.fail();
  if (body.left() < std::min(count * size, sample - begin)) body.fail();
}

void check_locators(Cursor& body) noexcept {
  constexpr std::size_t kLocator = 24;
  const std::uint32_t n = body.u32();
  if (n > body.left() / kLocator) return body.fail();
  body.skip(n * kLocator);
}

bool is_submessage(std::uint8_t kind, std::uint8_t flags, Cursor body) noexcept {
  switch (kind) {
    case 0x15:
      check_data(body, flags);
      break;
    case 0x16:
      check_fragments(body, flags);
      break;
    case 0x07: {  // HEARTBEAT
      body.skip(8);
      const std::int64_t first = body.sequence(1);
      if (body.sequence(0) < first - 1) body.fail();
      body.skip(4);
      break;
    }
    case 0x06:  // ACKNACK
      body.skip(8);
      static_cast<void>(body.sequence(0));
      body.bits();
      body.skip(4);
      break;
    case 0x08: {  // GAP
      body.skip(8);
      const std::int64_t start = body.sequence(1);
      if (body.sequence(1) < start) body.fail();
      body.bits();
      break;
    }
    case 0x12:  // NACK_FRAG
      body.skip(8);
      static_cast<void>(body.sequence(1));
      if (body.u32() == 0) body.fail();
      body.bits();
      body.skip(4);
      break;
    case 0x13:  // HEARTBEAT_FRAG
      body.skip(8);
      static_cast<void>(body.sequence(1));
      if (body.u32() == 0) body.fail();
      body.skip(4);
      break;
    case 0x09:  // INFO_TS, which may be without one
      if ((flags & 2) == 0) body.skip(8);
      break;
    case 0x0c:  // INFO_SRC
      body.skip(20);
      break;
    case 0x0e:  // INFO_DST
      body.skip(12);
      break;
    case 0x0f:  // INFO_REPLY, of one or two lists
      check_locators(body);
      if ((flags & 2) != 0) check_locators(body);
      break;
    case 0x0d:  // INFO_REPLY_IP4
      body.skip((flags & 2) != 0 ? 16 : 8);
      break;
    case 0x30: {  // SEC_BODY: its length is big endian in whatever message
      const std::uint32_t size = body.id();
      body.skip(size);
      break;
    }
    case 0x31:  // SEC_PREFIX, SRTPS_PREFIX: kind, key, session, vector
    case 0x33:
      body.skip(20);
      break;
    case 0x32:  // SEC_POSTFIX, SRTPS_POSTFIX: the common authentication, and those for single readers
    case 0x34: {
      body.skip(16);
      const std::uint32_t n = body.id();
      if (n > body.left() / 20) body.fail();
      break;
    }
    default:
      break;  // of later versions and of vendors, which are skipped
  }
  return body.ok();
}

}  // namespace

std::size_t readable_rtps(std::span<const std::uint8_t> message) noexcept {
  constexpr std::uint8_t kStatistics = 0x80;
  constexpr std::array<std::uint8_t, 5> kBegin{'R', 'T', 'P', 'S', 2};
  if (message.size() < kHeader || !std::equal(kBegin.begin(), kBegin.end(), message.begin())) return 0;
  for (auto left = message.subspan(kHeader); !left.empty();) {
    if (left.size() < 4) return 0;
    const std::uint8_t kind = left[0];
    const std::uint8_t flags = left[1];
    Cursor head{left.subspan(2, 2), (flags & kLittle) != 0};
    std::size_t size = head.u16();
    const std::size_t begin = message.size() - left.size();
    left = left.subspan(4);
    // Of the last one none: it is what is left. PAD and INFO_TS may have none.
    if (size == 0 && kind != 0x01 && kind != 0x09) size = left.size();
    if (size > left.size() || !is_submessage(kind, flags, {left.first(size), (flags & kLittle) != 0}))
      return 0;
    // Fast DDS goes on at the next multiple of four, wherever the submessage says that it ends.
    left = left.subspan(std::min((size + 3) & ~std::size_t{3}, left.size()));
    if (kind == kStatistics) return left.empty() ? begin : 0;
  }
  return message.size();
}

}  // namespace takt::dds
