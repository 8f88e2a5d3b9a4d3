#include <takt/wire/rtps.hpp>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace takt::wire {

namespace {

constexpr std::size_t kHeader = 20;
constexpr std::uint32_t kMostBits = 256;  // largest number of bits in a set of sequence or fragment numbers
// The largest accepted sequence number. Fast DDS adds small numbers to it, and must not overflow.
constexpr std::int64_t kMostNumber = std::int64_t{1} << 62;
// The largest accepted base of a set of fragment numbers. If a number in the set overflowed, Fast DDS would
// send fragment 1 in an endless loop.
constexpr std::uint32_t kMostFragment = 0xffffffff - kMostBits;

/// Reads values from a sequence of bytes in one byte order. If the bytes end within a value, this value and
/// all later values are 0.
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
    taken_ += n;
    return taken;
  }
  void skip(std::size_t n) noexcept { static_cast<void>(bytes(n)); }
  std::uint32_t u16() noexcept { return number(2); }
  std::uint32_t u32() noexcept { return number(4); }
  /// Reads an entity id, which is always big endian.
  std::uint32_t id() noexcept {
    std::uint32_t value = 0;
    for (const std::uint8_t byte : bytes(4)) value = value << 8U | byte;
    return value;
  }
  /// Reads a sequence number; fails if it is less than `least`.
  std::int64_t sequence(std::int64_t least) noexcept {
    const auto high = static_cast<std::int32_t>(u32());
    const std::int64_t value = static_cast<std::int64_t>(high) * (std::int64_t{1} << 32) + u32();
    if (value >= least && value <= kMostNumber) return value;
    fail();
    return least;
  }
  /// Skips the bits of a set of sequence or fragment numbers. The caller must already have read the base of
  /// the set.
  void bits() noexcept {
    const std::uint32_t n = u32();
    if (n > kMostBits) return fail();
    skip((n + 31) / 32 * 4);
  }
  /// Reads a CDR string, which begins with its length and ends with a zero byte.
  std::string_view text() noexcept {
    const std::uint32_t size = u32();
    const auto characters = bytes(size);
    if (size == 0 && ok_) return {};
    if (characters.empty() || characters.back() != 0) {
      fail();
      return {};
    }
    align();
    return {reinterpret_cast<const char*>(characters.data()), characters.size() - 1};
  }
  /// Reads the number of items that follow, each of `size` bytes. Returns true if the data contains so many
  /// items.
  bool fits(std::size_t size) noexcept {
    const std::uint32_t n = u32();
    return ok_ && n <= left() / size;
  }
  std::span<const std::uint8_t> octets() noexcept {
    const auto content = bytes(u32());
    align();
    return content;
  }
  /// Skips the padding up to the next multiple of four bytes. At the end of the data, padding may be missing.
  void align() noexcept { skip(std::min<std::size_t>((4 - taken_ % 4) % 4, left_.size())); }
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
  std::size_t taken_ = 0;
  bool little_;
  bool ok_ = true;
};

// ---- Parameter lists

enum class Content {
  any,
  text,
  texts,
  properties,
  token,
  octets,
  locator,
  guid,
  number,
  shorts,
  longs,
  filter
};

constexpr std::uint32_t kMustUnderstand = 0x4000;

Content content_of(std::uint32_t parameter) noexcept {
  switch (parameter & ~kMustUnderstand) {
    case 0x05:  // topic name
    case 0x07:  // type name
    case 0x62:  // entity name
      return Content::text;
    case 0x29:  // partition
      return Content::texts;
    case 0x59:
      return Content::properties;
    case 0x1001:  // identity token, permissions token
    case 0x1002:
      return Content::token;
    case 0x2c:  // user, group and topic data
    case 0x2d:
    case 0x2e:
      return Content::octets;
    case 0x2f:  // locators of endpoints and participants, unicast and multicast
    case 0x30:
    case 0x31:
    case 0x32:
    case 0x33:
    case 0x48:
      return Content::locator;
    case 0x50:  // GUIDs of participants, endpoints and groups
    case 0x52:
    case 0x5a:
    case 0x70:  // key hash
      return Content::guid;
    case 0x58:  // built-in endpoints
    case 0x71:  // disposed, unregistered
    case 0x77:
      return Content::number;
    case 0x73:  // data representations
      return Content::shorts;
    case 0x8006:  // domains of data sharing
      return Content::longs;
    case 0x35:  // content filter
      return Content::filter;
    default:
      return Content::any;
  }
}

void check_texts(Cursor& value) noexcept {
  for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n) {
    value.text();
    value.text();
  }
}

void check_properties(Cursor& value) noexcept {
  check_texts(value);
  // Properties with binary values may follow.
  if (value.left() < 4) return;
  for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n) {
    value.text();
    value.octets();
  }
}

/// Checks a token, which Fast DDS calls a data holder. Calls `each` with the name and value of each binary
/// property; `each` returns true if the property is valid.
template <class Each>
void check_token(Cursor& value, Each&& each) noexcept {
  value.text();
  check_texts(value);
  for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n) {
    const std::string_view name = value.text();
    const auto octets = value.octets();
    if (value.ok() && !each(name, octets)) value.fail();
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
      // A text of length 0 is rejected: Fast DDS would read on to the next zero byte, even beyond the
      // message.
      for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n)
        if (value.text().data() == nullptr) value.fail();
      break;
    case Content::properties:
      check_properties(value);
      break;
    case Content::token:
      check_token(value, [](std::string_view, std::span<const std::uint8_t>) { return true; });
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
    case Content::shorts:
      return value.fits(2);
    case Content::longs:
      return value.fits(8);
    case Content::filter:
      for (int i = 0; i < 4; ++i) value.text();  // the names of the topics and of the class, the expression
      for (std::uint32_t n = value.u32(); n > 0 && value.ok(); --n) value.text();
      break;
  }
  return value.ok();
}

constexpr std::uint8_t kPad = 0;  // Fast DDS skips a parameter with this id

/// Returns true if Takt does not need this parameter of an announcement.
bool is_unused(std::uint32_t parameter) noexcept {
  switch (parameter & ~kMustUnderstand) {
    case 0x35:  // content filter: the writers of Takt send all samples
    case 0x69:  // identifier and description of a type: types are compared by name
    case 0x72:
    case 0x75:
      return true;
    default:
      return false;
  }
}

/// Checks a parameter list including its end mark. Calls `each` with each valid parameter.
template <class Each>
void check_parameters(Cursor& list, Each&& each) noexcept {
  constexpr std::uint32_t kEnd = 1;
  while (list.ok()) {
    const std::uint32_t parameter = list.u16();
    const std::uint32_t size = list.u16();
    if (parameter == kEnd || !list.ok()) return;
    if (size % 4 != 0 || size > list.left()) return list.fail();
    const Cursor value = list.part(size);
    if (parameter != kPad && !is_parameter(parameter, value)) return list.fail();
    each(parameter, value);
  }
}
void check_parameters(Cursor& list) noexcept {
  check_parameters(list, [](std::uint32_t, const Cursor&) {});
}

/// Returns the part of a message that `value` has not read yet.
std::span<std::uint8_t> part_of(std::span<std::uint8_t> message, Cursor value) noexcept {
  return message.subspan(static_cast<std::size_t>(value.bytes(0).data() - message.data()), value.left());
}

/// Makes Fast DDS skip a parameter of a message.
void skip_parameter(std::span<std::uint8_t> message, const Cursor& value) noexcept {
  const std::size_t begin = static_cast<std::size_t>(part_of(message, value).data() - message.data()) - 4;
  message[begin] = message[begin + 1] = kPad;
}

// ---- Submessages

constexpr std::uint32_t kParticipants = 0x000100c2;  // entity id of the writer of participant announcements
constexpr std::uint32_t kParticipantGuid = 0x50;     // parameter that names a participant
constexpr std::uint32_t kDiscoveryAddress = 0x32;    // parameter with a unicast locator for discovery
constexpr std::uint32_t kUdpV4 = 1;                  // the kind of a locator
constexpr std::uint32_t kKeyHash = 0x70;  // parameter with the key of a sample, for participants the GUID
constexpr std::uint32_t kProofs = 0x000201c3;  // entity id of the writer of authentication messages
constexpr std::uint32_t kMostProof = 65535;    // largest size of an authentication message, in bytes

/// Returns true if this writer announces participants, readers or writers. Samples of such a writer contain a
/// parameter list.
bool discovers(std::uint32_t writer) noexcept {
  return writer == kParticipants || writer == 0x000002c2 || writer == 0x000003c2 || writer == 0x000004c2;
}

bool announces_participants(std::uint32_t writer) noexcept { return writer == kParticipants; }

constexpr std::uint8_t kLittle = 1;
constexpr std::uint8_t kInlineQos = 2;
constexpr std::uint8_t kData = 4;
// The number of bytes in DATA between the field octetsToInlineQos and the end of the sequence number.
constexpr std::uint32_t kBeforeData = 16;

/// Checks the first fields of DATA or DATA_FRAG: flags, octetsToInlineQos, reader, writer and sequence
/// number. `behind` is the number of bytes between octetsToInlineQos and the inline QoS. Returns the entity
/// id of the writer.
std::uint32_t check_head(Cursor& body, std::uint32_t behind) noexcept {
  body.skip(2);
  const std::uint32_t to_qos = body.u16();  // bytes from the end of this field to the inline QoS
  body.skip(4);
  const std::uint32_t writer = body.id();
  static_cast<void>(body.sequence(1));
  constexpr std::uint32_t kMostToQos = 0x7fff;  // Fast DDS reads to_qos as a signed number
  if (to_qos < behind || to_qos > behind + body.left() || to_qos > kMostToQos) body.fail();
  return writer;
}

/// Checks that an authentication message contains a sender, a receiver and a class, whose values do not
/// matter here, and that each of its tokens is valid (DDS Security 1.1, section 7.4.4).
void check_proof(Cursor& message, IsCertificate is_certificate) noexcept {
  message.skip(24 + 24 + 16 + 16 + 16);
  message.text();
  for (std::uint32_t n = message.u32(); n > 0 && message.ok(); --n)
    check_token(message, [&](std::string_view name, std::span<const std::uint8_t> value) {
      return name != "c.id" || is_certificate == nullptr || is_certificate(value);
    });
}

/// Checks the parameter list of an announcement of a participant. Fast DDS would accept a participant whose
/// GUID is missing or zero, and later fail an assertion.
void check_participant(Cursor& list) noexcept {
  bool named = false;
  bool known = true;
  check_parameters(list, [&](std::uint32_t parameter, Cursor value) {
    if (parameter == kParticipantGuid) named = true;
    if (parameter == kParticipantGuid || parameter == kKeyHash) {
      const auto prefix = value.bytes(12);
      known = known && std::ranges::any_of(prefix, [](std::uint8_t byte) { return byte != 0; });
    }
  });
  if (!named || !known) list.fail();
}

void check_data(Cursor& body, std::uint8_t flags, IsCertificate is_certificate) noexcept {
  constexpr std::uint8_t kKey = 8;
  Cursor copy = body;
  copy.skip(2);
  const std::uint32_t to_qos = copy.u16();
  const std::uint32_t writer = check_head(body, kBeforeData);
  if (!body.ok()) return;
  body.skip(to_qos - kBeforeData);
  if ((flags & kInlineQos) != 0) check_parameters(body);
  if ((flags & kData) != 0 && (flags & kKey) != 0) return body.fail();
  if ((flags & (kData | kKey)) == 0) return;
  const auto encapsulation = body.bytes(4);
  if (!body.ok() || (!discovers(writer) && writer != kProofs)) return;
  // The encapsulation must be PL_CDR if the content is a parameter list, and CDR otherwise. Both byte orders
  // are valid.
  const int plain = encapsulation[1] - (discovers(writer) ? 2 : 0);
  if (encapsulation[0] != 0 || (plain != 0 && plain != 1)) return body.fail();
  Cursor content{body.bytes(body.left()), plain == 1};
  if (writer == kProofs)
    check_proof(content, is_certificate);
  else if (writer == kParticipants && (flags & kData) != 0)
    check_participant(content);
  else
    check_parameters(content);
  if (!content.ok()) body.fail();
}

void check_fragments(Cursor& body, std::uint8_t flags) noexcept {
  constexpr std::uint32_t kBehind = 28;
  Cursor copy = body;
  copy.skip(2);
  const std::uint32_t to_qos = copy.u16();
  const std::uint32_t writer = check_head(body, 16);
  // Fragments of discovery messages are rejected, because Fast DDS reads such a message as soon as it has all
  // fragments, and Takt could not check the message before. is_readable_proof() checks a complete
  // authentication message.
  // Fragments of a key are rejected, because Fast DDS stores them as if they had no content.
  constexpr std::uint8_t kKey = 4;
  if (discovers(writer) || (flags & kKey) != 0) return body.fail();
  const std::uint64_t first = body.u32();
  const std::uint64_t count = body.u16();
  const std::uint64_t size = body.u16();
  const std::uint64_t sample = body.u32();
  if (!body.ok() || to_qos < kBehind || first == 0 || count == 0 || size == 0) return body.fail();
  if (writer == kProofs && sample > kMostProof) return body.fail();
  body.skip(to_qos - kBehind);
  if ((flags & kInlineQos) != 0) check_parameters(body);
  const std::uint64_t begin = (first - 1) * size;
  if (begin + (count - 1) * size >= sample) return body.fail();
  if (body.left() < std::min(count * size, sample - begin)) body.fail();
}

void check_locators(Cursor& body) noexcept {
  constexpr std::size_t kLocator = 24;
  body.skip(body.u32() * kLocator);
}

bool is_submessage(std::uint8_t kind, std::uint8_t flags, Cursor body,
                   IsCertificate is_certificate) noexcept {
  switch (kind) {
    case 0x15:
      check_data(body, flags, is_certificate);
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
      if (const std::uint32_t base = body.u32(); base == 0 || base > kMostFragment) body.fail();
      body.bits();
      body.skip(4);
      break;
    case 0x13:  // HEARTBEAT_FRAG
      body.skip(8);
      static_cast<void>(body.sequence(1));
      if (body.u32() == 0) body.fail();
      body.skip(4);
      break;
    case 0x09:  // INFO_TS; the timestamp is missing if flag 2 is set
      if ((flags & 2) == 0) body.skip(8);
      break;
    case 0x0c:  // INFO_SRC
      body.skip(20);
      break;
    case 0x0e:  // INFO_DST
      body.skip(12);
      break;
    case 0x0f:  // INFO_REPLY, with one or two locator lists
      check_locators(body);
      if ((flags & 2) != 0) check_locators(body);
      break;
    case 0x0d:  // INFO_REPLY_IP4
      body.skip((flags & 2) != 0 ? 16 : 8);
      break;
    case 0x30: {  // SEC_BODY, whose length is always big endian
      const std::uint32_t size = body.id();
      body.skip(size);
      break;
    }
    case 0x31:  // SEC_PREFIX and SRTPS_PREFIX contain transformation kind, key id, session id and
                // initialization vector
    case 0x33:
      body.skip(20);
      break;
    case 0x32:  // SEC_POSTFIX and SRTPS_POSTFIX contain a common authentication code and one code for each
                // listed reader
    case 0x34: {
      body.skip(16);
      const std::uint32_t n = body.id();
      if (n > body.left() / 20) body.fail();
      break;
    }
    default:
      break;  // submessages of later RTPS versions and vendor-specific submessages are not checked
  }
  return body.ok();
}

/// Iterates over submessages as Fast DDS does: each submessage begins at a multiple of four bytes, even if
/// the length of the previous one says otherwise.
class Submessages {
 public:
  explicit Submessages(std::span<const std::uint8_t> message) noexcept : left_(message.subspan(kHeader)) {}

  struct One {
    std::uint8_t kind = 0;
    std::uint8_t flags = 0;
    bool last = false;  // true if the length field is 0: then the submessage extends to the end of the
                        // message
    std::span<const std::uint8_t> body;
    [[nodiscard]] bool little() const noexcept { return (flags & kLittle) != 0; }
  };
  [[nodiscard]] bool empty() const noexcept { return left_.empty(); }
  [[nodiscard]] std::size_t left() const noexcept { return left_.size(); }
  /// Returns the next submessage. If the submessage extends past the end of the message, returns one of kind
  /// 0, a kind that RTPS does not define.
  One next() noexcept {
    if (left_.size() < 4) return {};
    One one{.kind = left_[0], .flags = left_[1], .last = false, .body = {}};
    Cursor head{left_.subspan(2, 2), one.little()};
    std::size_t size = head.u16();
    left_ = left_.subspan(4);
    // PAD and INFO_TS may have length 0.
    one.last = size == 0 && one.kind != 0x01 && one.kind != 0x09;
    if (one.last) size = left_.size();
    if (size > left_.size()) return {};
    one.body = left_.first(size);
    left_ = left_.subspan(std::min((size + 3) & ~std::size_t{3}, left_.size()));
    return one;
  }

 private:
  std::span<const std::uint8_t> left_;
};

/// Calls `each` with the parameter list in each DATA of a writer for which `of` returns true.
template <class Of, class Each>
void for_each_list(std::span<const std::uint8_t> message, Of&& of, Each&& each) noexcept {
  for (Submessages rest{message}; !rest.empty();) {
    const auto one = rest.next();
    if (one.kind != 0x15 || (one.flags & kData) == 0) continue;
    Cursor body{one.body, one.little()};
    Cursor copy = body;
    copy.skip(2);
    const std::uint32_t to_qos = copy.u16();
    if (!of(check_head(body, kBeforeData))) continue;
    body.skip(to_qos - kBeforeData);
    // Skip the inline QoS. It can announce that the participant leaves; Fast DDS handles such an
    // announcement.
    if ((one.flags & kInlineQos) != 0) check_parameters(body);
    const auto encapsulation = body.bytes(4);
    if (body.ok()) each(Cursor{body.bytes(body.left()), encapsulation[1] == 3});
  }
}

constexpr std::uint8_t kMessagePrefix = 0x33;     // SRTPS_PREFIX
constexpr std::uint8_t kSubmessagePrefix = 0x31;  // SEC_PREFIX
constexpr std::size_t kSender = 8;                // where the sender's number is in the header
// The header of version 2.2 and of the vendor eProsima, and a submessage in little-endian byte order. The
// numbers of the two participants are 0.
constexpr LossReport kLossReport{'R', 'T', 'P', 'S', 2, 2, 1,    15, 0,  0, 0,   0,   0,   0,
                                 0,   0,   0,   0,   0, 0, 0xf7, 1,  16, 0, 'l', 'o', 's', 't'};

bool is_header(std::span<const std::uint8_t> message) noexcept {
  constexpr std::array<std::uint8_t, 5> kBegin{'R', 'T', 'P', 'S', 2};
  return message.size() > kHeader && std::equal(kBegin.begin(), kBegin.end(), message.begin());
}

/// Returns true if an encrypted body and authentication codes follow this SEC_PREFIX or SRTPS_PREFIX, each
/// with a length that matches its content.
bool is_protected(const Submessages::One& prefix, Submessages& rest) noexcept {
  const auto postfix_kind = static_cast<std::uint8_t>(prefix.kind + 1);
  if (prefix.body.size() != 20) return false;
  const auto body = rest.next();
  if (body.kind != 0x30) return false;
  Cursor size{body.body, false};
  if (((size.u32() + 3U) & ~3U) + 4 != ((body.body.size() + 3) & ~std::size_t{3})) return false;
  const auto postfix = rest.next();
  if (postfix.kind != postfix_kind || postfix.last) return false;
  Cursor authentication{postfix.body, false};
  authentication.skip(16);
  return authentication.u32() * std::size_t{20} + 20 == postfix.body.size();
}

}  // namespace

std::size_t readable_rtps(std::span<const std::uint8_t> message, IsCertificate is_certificate) noexcept {
  constexpr std::uint8_t kStatistics = 0x80;
  if (!is_header(message)) return 0;
  for (Submessages rest{message}; !rest.empty();) {
    const std::size_t begin = message.size() - rest.left();
    const auto one = rest.next();
    if (one.kind == 0 || !is_submessage(one.kind, one.flags, {one.body, one.little()}, is_certificate))
      return 0;
    if (one.kind == kStatistics) return rest.empty() && begin > kHeader ? begin : 0;
  }
  return message.size();
}

bool is_readable_proof(std::span<const std::uint8_t> content, IsCertificate is_certificate) noexcept {
  if (content.size() < 4 || content[0] != 0 || content[1] > 1) return false;
  Cursor message{content.subspan(4), content[1] == 1};
  check_proof(message, is_certificate);
  return message.ok();
}

void skip_unused_parameters(std::span<std::uint8_t> message) noexcept {
  for_each_list(message, discovers, [&](Cursor list) {
    check_parameters(list, [&](std::uint32_t parameter, Cursor value) {
      if (is_unused(parameter)) skip_parameter(message, value);
    });
  });
}

std::vector<std::array<std::uint8_t, 4>> replace_addresses(std::span<std::uint8_t> message,
                                                           const ParticipantNumber& participant,
                                                           const std::array<std::uint8_t, 4>& address,
                                                           std::uint16_t port) {
  constexpr std::size_t kPort = 4;      // where the port is in a locator
  constexpr std::size_t kAddress = 20;  // where the IPv4 address is
  std::vector<std::array<std::uint8_t, 4>> addresses;
  for_each_list(message, announces_participants, [&](Cursor list) {
    bool is_announced = false;
    Cursor again = list;
    check_parameters(list, [&](std::uint32_t parameter, Cursor value) {
      if (parameter == kParticipantGuid)
        is_announced = std::ranges::equal(value.bytes(participant.size()), participant);
    });
    if (!is_announced) return;
    bool is_replaced = false;
    check_parameters(again, [&](std::uint32_t parameter, Cursor value) {
      if (parameter != kDiscoveryAddress || Cursor{value}.u32() != kUdpV4) return;
      const std::span<std::uint8_t> locator = part_of(message, value);
      std::ranges::copy(locator.subspan(kAddress), addresses.emplace_back().begin());
      if (std::exchange(is_replaced, true)) return skip_parameter(message, value);
      for (std::size_t i = 0; i < 4; ++i)
        locator[kPort + i] = static_cast<std::uint8_t>(port >> 8U * (list.little() ? i : 3 - i));
      std::ranges::copy(address, locator.begin() + kAddress);
    });
  });
  return addresses;
}

bool is_protected_rtps(std::span<const std::uint8_t> message) noexcept {
  for (Submessages rest{message}; !rest.empty();) {
    const bool first = rest.left() == message.size() - kHeader;
    const auto one = rest.next();
    switch (one.kind) {
      case kMessagePrefix:
        return first && is_protected(one, rest) && rest.empty();
      case kSubmessagePrefix:
        if (!is_protected(one, rest)) return false;
        break;
      case 0x01:  // PAD, INFO_TS and INFO_DST may be unencrypted
      case 0x09:
      case 0x0e:
        break;
      case 0x15: {
        Cursor body{one.body, one.little()};
        const std::uint32_t writer = check_head(body, kBeforeData);
        if (writer != kParticipants && writer != kProofs) return false;
        break;
      }
      case 0x16: {
        Cursor body{one.body, one.little()};
        if (check_head(body, kBeforeData) != kProofs) return false;
        break;
      }
      default:
        if (one.kind < 0x80) return false;  // vendor-specific submessages may be unencrypted
    }
  }
  return true;
}

bool is_encrypted(std::span<const std::uint8_t> message) noexcept {
  for (Submessages rest{message}; !rest.empty();) {
    const std::uint8_t kind = rest.next().kind;
    if (kind == kMessagePrefix || kind == kSubmessagePrefix) return true;
  }
  return false;
}

bool concerns_participants(std::span<const std::uint8_t> message) noexcept {
  for (Submessages rest{message}; !rest.empty();) {
    const auto one = rest.next();
    if (one.kind != 0x15) continue;
    Cursor body{one.body, one.little()};
    if (check_head(body, kBeforeData) == kParticipants) return true;
  }
  return false;
}

ParticipantNumber sender_of(std::span<const std::uint8_t> message) noexcept {
  ParticipantNumber number{};
  std::ranges::copy(message.subspan(kHeader - number.size(), number.size()), number.begin());
  return number;
}

Announcement announcement_in(std::span<const std::uint8_t> message) noexcept {
  constexpr std::uint32_t kLease = 0x02;
  constexpr std::uint32_t kName = 0x62;
  constexpr std::uint32_t kIdentity = 0x1001;
  constexpr std::uint32_t kVersion = 0x8000;  // Fast DDS only
  Announcement found;
  found.number = sender_of(message);
  const auto is_sender = [&](Cursor value) {
    return std::ranges::equal(value.bytes(found.number.size()), found.number);
  };
  const auto read_identity = [&](Cursor token) {
    token.text();  // the class of the token
    for (std::uint32_t n = token.u32(); n > 0 && token.ok(); --n) {
      const std::string_view property = token.text();
      const std::string_view value = token.text();
      if (property == "dds.cert.sn") found.subject = value;
      if (property == "dds.ca.sn") found.authority = value;
    }
  };
  for_each_list(message, announces_participants, [&](Cursor list) {
    bool from_itself = true;
    check_parameters(list, [&](std::uint32_t parameter, Cursor value) {
      if (parameter == kParticipantGuid || parameter == kKeyHash)
        from_itself = from_itself && is_sender(value);
      if (parameter == kLease) found.lease_s = value.u32();
      if ((parameter & ~kMustUnderstand) == kName) found.name = value.text();
      if ((parameter & ~kMustUnderstand) == kIdentity) read_identity(value);
      if (parameter == kVersion) found.has_version = true;
      if (parameter == kDiscoveryAddress && value.u32() == kUdpV4)
        found.port = static_cast<std::uint16_t>(value.u32());
    });
    const bool again = found.of != Announcement::Of::nobody;
    found.of = from_itself && !again ? Announcement::Of::sender : Announcement::Of::other;
  });
  return found;
}

LossReport loss_report(const ParticipantNumber& sender, const ParticipantNumber& lost) noexcept {
  LossReport message = kLossReport;
  std::ranges::copy(sender, message.begin() + kSender);
  std::ranges::copy(lost, message.end() - static_cast<std::ptrdiff_t>(lost.size()));
  return message;
}

bool is_loss_report(std::span<const std::uint8_t> bytes, const ParticipantNumber& lost) noexcept {
  return bytes.size() == kLossReport.size() && std::ranges::equal(bytes, loss_report(sender_of(bytes), lost));
}

}  // namespace takt::wire
