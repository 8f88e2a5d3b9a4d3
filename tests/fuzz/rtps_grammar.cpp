#include "rtps_grammar.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include <takt/core/check.hpp>

namespace fuzz {

namespace {

constexpr std::uint8_t kPad = 0x01, kAcknack = 0x06, kHeartbeat = 0x07, kGap = 0x08, kInfoTs = 0x09,
                       kInfoSrc = 0x0c, kInfoReplyIp4 = 0x0d, kInfoDst = 0x0e, kInfoReply = 0x0f,
                       kNackFrag = 0x12, kHeartbeatFrag = 0x13, kData = 0x15, kDataFrag = 0x16,
                       kSecBody = 0x30, kSecPrefix = 0x31, kSecPostfix = 0x32, kSrtpsPrefix = 0x33,
                       kSrtpsPostfix = 0x34, kStatistics = 0x80;
constexpr std::uint32_t kParticipants = 0x000100c2, kPublications = 0x000003c2, kSubscriptions = 0x000004c2,
                        kTopics = 0x000002c2, kProofs = 0x000201c3, kLiveliness = 0x000200c2,
                        kParticipantId = 0x000001c1;
constexpr std::int64_t kMost = std::int64_t{1} << 62;

const std::vector<std::uint32_t>& builtin_writers() {
  static const std::vector<std::uint32_t> all{kParticipants,  kPublications, kSubscriptions, kPublications,
                                              kSubscriptions, kTopics,       kProofs,        kLiveliness,
                                              0x000300c3,     0x000301c3,    0xff0003c2,     0xff0004c2,
                                              0xff0200c2,     0xff0202c3,    0xff0101c2,     0x00000000};
  return all;
}

std::uint32_t builtin_reader(std::uint32_t writer) {
  const std::uint32_t kind = writer & 0xffU;
  return (writer & ~0xffU) | (kind == 0xc2 ? 0xc7U : kind == 0xc3 ? 0xc4U : kind);
}

bool is_builtin(std::uint32_t id) { return (id & 0xc0U) == 0xc0; }

/// All parameters of RTPS 2.5, DDS Security 1.1, XTypes 1.3 and eProsima.
const std::vector<std::uint32_t>& all_parameters() {
  static const std::vector<std::uint32_t> all{
      0x00,   0x02,   0x04,   0x05,   0x06,   0x07,   0x0b,   0x0c,   0x0d,   0x0e,   0x0f,   0x11,
      0x15,   0x16,   0x1a,   0x1b,   0x1d,   0x1e,   0x1f,   0x21,   0x23,   0x25,   0x27,   0x29,
      0x2b,   0x2c,   0x2d,   0x2e,   0x2f,   0x30,   0x31,   0x32,   0x33,   0x34,   0x35,   0x40,
      0x41,   0x43,   0x44,   0x45,   0x46,   0x48,   0x49,   0x50,   0x51,   0x52,   0x53,   0x55,
      0x56,   0x57,   0x58,   0x59,   0x5a,   0x60,   0x61,   0x62,   0x63,   0x64,   0x65,   0x66,
      0x69,   0x70,   0x71,   0x72,   0x73,   0x74,   0x75,   0x77,   0x83,   0x1001, 0x1002, 0x1003,
      0x1004, 0x1005, 0x1006, 0x4014, 0x8000, 0x8001, 0x8002, 0x8005, 0x8006, 0x8007, 0x800f, 0x3fff};
  return all;
}

/// Larger than any message.
const std::vector<std::uint32_t>& too_many() {
  static const std::vector<std::uint32_t> all{0x10000,    0x1000000,  0x20000000, 0x40000000, 0x7fffffff,
                                              0x80000000, 0xfffffff8, 0xfffffffc, 0xfffffffe, 0xffffffff};
  return all;
}

const char* const kRuleNames[] = {"none",
#define TAKT_NAME(name) #name,
                                  TAKT_RTPS_RULES(TAKT_NAME)
#undef TAKT_NAME
};

}  // namespace

const char* to_text(Rule rule) { return kRuleNames[static_cast<std::size_t>(rule)]; }

// SplitMix64
std::uint64_t Dice::next() {
  std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111eb;
  return z ^ (z >> 31U);
}

// ---- Body

Body& Body::put(std::uint64_t value, unsigned n) {
  for (unsigned i = 0; i < n; ++i)
    bytes.push_back(static_cast<std::uint8_t>(value >> 8U * (little ? i : n - 1 - i)));
  return *this;
}
Body& Body::id(std::uint32_t value) { return u8(value >> 24U).u8(value >> 16U).u8(value >> 8U).u8(value); }
Body& Body::number(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  return u32(bits >> 32U).u32(bits);
}
Body& Body::zeros(std::size_t n) {
  bytes.resize(bytes.size() + n);
  return *this;
}
Body& Body::text(const std::string& characters) {
  u32(characters.size() + 1);
  bytes.insert(bytes.end(), characters.begin(), characters.end());
  return zeros(1).align();
}
Body& Body::octets(const Octets& content) { return u32(content.size()).add(content).align(); }
Body& Body::add(const Octets& content) {
  bytes.insert(bytes.end(), content.begin(), content.end());
  return *this;
}

// ---- Numbers

Grammar::Grammar(Ports ports, const Prefix& mine, std::vector<Endpoint> readers,
                 std::vector<Endpoint> writers, Octets certificate)
    : ports_(ports),
      mine_(mine),
      readers_(std::move(readers)),
      writers_(std::move(writers)),
      certificate_(std::move(certificate)) {}

Prefix Grammar::peer(std::size_t i) {
  Prefix prefix{1, 15, 0xf0, 0x0d};
  prefix[11] = static_cast<std::uint8_t>(i + 1);
  return prefix;
}

bool Grammar::breaks(Rule rule) {
  if (target_ != rule || rule == Rule::none) return false;
  broken_ = true;
  return true;
}

std::uint64_t Grammar::edge() {
  static const std::vector<std::uint64_t> all{
      0,       1,          2,          3,          4,          5,          7,      8,
      16,      0x7f,       0x80,       0xff,       0x100,      0x7fff,     0x8000, 0xffff,
      0x10000, 0x7fffffff, 0x80000000, 0xfffffffe, 0xffffffff, 0x100000000};
  return dice_->once_in(3) ? dice_->next() : dice_->of(all);
}

/// A valid sequence number, usually one that a reader soon expects.
std::int64_t Grammar::number_near(std::int64_t next) {
  if (dice_->once_in(40)) {
    static const std::vector<std::int64_t> far{0x7fffffff,  0x80000000,  0xffffffff,
                                               0x100000000, 0x100000001, std::int64_t{1} << 61,
                                               kMost - 1,   kMost,       std::int64_t{1} << 30};
    return dice_->of(far);
  }
  static const std::vector<std::int64_t> steps{0,  0,  0,  0,  0,   1,   1,   2,   3,
                                               -1, -2, 31, 32, 255, 256, 257, 5000};
  return std::clamp<std::int64_t>(next + dice_->of(steps), 1, kMost);
}
std::int64_t Grammar::low() {
  static const std::vector<std::int64_t> all{0,           0, -1, -2, std::numeric_limits<std::int64_t>::min(),
                                             -0x100000000};
  return dice_->of(all);
}
std::int64_t Grammar::high() {
  static const std::vector<std::int64_t> all{kMost + 1, kMost + 2, std::numeric_limits<std::int64_t>::max()};
  return dice_->of(all);
}

/// Leaves at least one byte and at most `most`.
void Grammar::cut(Body& body, std::size_t most) {
  body.bytes.resize(dice_->once_in(2) ? most - dice_->below(std::min<std::size_t>(most, 4))
                                      : 1 + dice_->below(most));
}

std::size_t Grammar::any_reader() { return dice_->once_in(2) ? favourite_ : dice_->below(readers_.size()); }

Octets Grammar::random(std::size_t n) {
  Octets bytes(n);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(dice_->next());
  return bytes;
}

std::string Grammar::words() {
  static const std::vector<std::string> known{
      "",  "a",        "takt/command", "takt::Command", "*",           "rt/?",       "fuzz",
      "[", "a*b?c[d]", "DDSSQL",       "x > %0",        "PARTICIPANT", "takt/device"};
  if (!dice_->once_in(4)) return dice_->of(known);
  return std::string(dice_->below(dice_->once_in(8) ? 600 : 24), static_cast<char>('a' + dice_->below(26)));
}

// ---- Parameters

std::uint32_t Grammar::many(std::uint32_t n, Rule rule) { return breaks(rule) ? dice_->of(too_many()) : n; }

void Grammar::put_text(Body& body, Rule too_long, Rule without_end) {
  if (breaks(too_long)) {
    body.u32(dice_->of(too_many())).add(random(4 * dice_->below(8)));
  } else if (breaks(without_end)) {
    const Octets characters(4 * (1 + dice_->below(8)), 'a');
    body.octets(characters);
  } else {
    body.text(words());
  }
}

void Grammar::put_token(Body& body, bool in_proof) {
  static const std::vector<std::string> classes{"DDS:Auth:PKI-DH:1.0",        "DDS:Auth:PKI-DH:1.0+Req",
                                                "DDS:Auth:PKI-DH:1.0+Reply",  "DDS:Auth:PKI-DH:1.0+Final",
                                                "DDS:Access:Permissions:1.0", "DDS:Auth:PKI-DH:1.0+AuthReq"};
  static const std::vector<std::string> names{
      "c.perm", "c.pdata",    "c.dsign_algo", "c.kagree_algo", "hash_c1",     "hash_c2",          "dh1",
      "dh2",    "challenge1", "challenge2",   "signature",     "ocsp_status", "future_challenge", ""};
  if (in_proof && breaks(Rule::proof_token_too_long)) {
    body.u32(dice_->of(too_many())).zeros(4);
    return;
  }
  if (breaks(Rule::token_class_too_long)) {
    body.u32(dice_->of(too_many())).add(random(16));
    return;
  }
  if (dice_->once_in(8))
    body.u32(0);
  else
    body.text(dice_->of(classes));
  const auto properties = static_cast<std::uint32_t>(dice_->below(3));
  body.u32(many(properties, Rule::token_too_many_properties));
  for (std::uint32_t i = 0; i < properties; ++i) body.text("dds.cert.sn").text(words());
  const bool of_nobody = in_proof && breaks(Rule::proof_of_nobody);
  const bool with_identity = of_nobody || (in_proof && !certificate_.empty() && dice_->once_in(2));
  const auto binary = static_cast<std::uint32_t>(dice_->below(4));
  body.u32(many(binary + (with_identity ? 1 : 0), Rule::token_too_many_binary_properties));
  if (with_identity) body.text("c.id").octets(of_nobody ? random(dice_->below(64)) : certificate_);
  for (std::uint32_t i = 0; i < binary; ++i) {
    body.text(dice_->of(names));
    if (breaks(Rule::token_binary_too_long)) {
      body.u32(dice_->of(too_many())).zeros(4);
      return;
    }
    body.octets(random(dice_->once_in(4) ? dice_->below(300) : dice_->below(33)));
  }
  if (target_ == Rule::token_binary_too_long && binary == 0) target_ = Rule::none;
}

Octets Grammar::value_of(std::uint32_t parameter, bool is_little) {
  Body value{is_little};
  const auto put_number = [&](Rule rule, std::size_t right) {
    const std::size_t size = breaks(rule) ? (right + 4 + 4 * dice_->below(8)) % 44 : right;
    if (size != right) value.add(random(size));
    return size == right;
  };
  const auto guid = [&] {
    const Prefix& of = dice_->once_in(16) ? mine_ : dice_->once_in(16) ? peer(dice_->below(kPeers)) : from_;
    value.add({of.begin(), of.end()});
    value.id(dice_->once_in(4) ? static_cast<std::uint32_t>(edge()) : kParticipantId);
  };
  switch (parameter) {
    case 0x05:
    case 0x07:
    case 0x62:
      if (!breaks(Rule::text_missing)) put_text(value, Rule::text_too_long, Rule::text_without_end);
      break;
    case 0x29: {
      const auto n = static_cast<std::uint32_t>(dice_->below(4));
      value.u32(breaks(Rule::texts_too_many) ? (dice_->once_in(2) ? n + 1 : dice_->of(too_many()))
                                             : n + (target_ == Rule::texts_empty_one ? 1 : 0));
      if (breaks(Rule::texts_empty_one)) value.u32(0);
      for (std::uint32_t i = 0; i < n; ++i) value.text(words());
      break;
    }
    case 0x59: {
      const auto n = static_cast<std::uint32_t>(dice_->below(3));
      value.u32(many(n, Rule::properties_too_many));
      for (std::uint32_t i = 0; i < n; ++i)
        value.text(dice_->once_in(2) ? "PARTICIPANT_TYPE" : "fastdds.physical_data.host").text(words());
      if (dice_->once_in(2) && target_ != Rule::binary_properties_too_many &&
          target_ != Rule::binary_property_too_long)
        break;
      const auto binary = static_cast<std::uint32_t>(1 + dice_->below(2));
      value.u32(many(binary, Rule::binary_properties_too_many));
      for (std::uint32_t i = 0; i < binary; ++i) {
        value.text(words());
        if (breaks(Rule::binary_property_too_long))
          value.u32(dice_->of(too_many())).zeros(4);
        else
          value.octets(random(dice_->below(20)));
      }
      break;
    }
    case 0x1001:
    case 0x1002:
      put_token(value, false);
      break;
    case 0x2c:
    case 0x2d:
    case 0x2e:
      if (breaks(Rule::octets_too_long))
        value.u32(dice_->of(too_many())).zeros(4 * dice_->below(4));
      else
        value.octets(random(dice_->below(dice_->once_in(16) ? 400 : 20)));
      break;
    case 0x2f:
    case 0x30:
    case 0x31:
    case 0x32:
    case 0x33:
    case 0x48: {
      if (!put_number(Rule::locator_size, 24)) break;
      value.u32(dice_->once_in(4) ? edge() : 1).u32(dice_->once_in(4) ? edge() : ports_.peers);
      const bool multicast = parameter == 0x30 || parameter == 0x33 || parameter == 0x48;
      value.zeros(12).add(dice_->once_in(8) ? random(4)
                          : multicast       ? Octets{239, 255, 0, 1}
                                            : Octets{127, 0, 0, 1});
      break;
    }
    case 0x50:
    case 0x52:
    case 0x5a:
    case 0x70:
      if (put_number(Rule::guid_size, 16)) guid();
      break;
    case 0x58:
    case 0x71:
    case 0x77:
      if (put_number(Rule::number_size, 4)) value.u32(dice_->once_in(2) ? 0x0c3f : edge());
      break;
    case 0x73: {
      const auto n = static_cast<std::uint32_t>(dice_->below(5));
      value.u32(breaks(Rule::shorts_too_many) ? (dice_->once_in(2) ? n + 3 : dice_->of(too_many())) : n);
      for (std::uint32_t i = 0; i < n; ++i) value.u16(dice_->below(3));
      break;
    }
    case 0x8006: {
      const auto n = static_cast<std::uint32_t>(dice_->below(4));
      value.u32(breaks(Rule::longs_too_many) ? (dice_->once_in(2) ? n + 1 : dice_->of(too_many())) : n);
      value.add(random(8 * n));
      break;
    }
    case 0x35: {
      const std::uint64_t bad = dice_->below(4);
      for (std::uint64_t i = 0; i < 4; ++i)
        put_text(value, i == bad ? Rule::filter_text_too_long : Rule::none);
      const auto n = static_cast<std::uint32_t>(dice_->below(3));
      value.u32(breaks(Rule::filter_too_many) ? (dice_->once_in(2) ? n + 1 : dice_->of(too_many())) : n);
      for (std::uint32_t i = 0; i < n; ++i) value.text(words());
      break;
    }
    default: {
      // Policies and other parameters that the filter does not check.
      static const std::vector<std::size_t> sizes{0, 4, 4, 4, 8, 8, 12, 16, 24, 28, 64};
      const std::size_t size = dice_->of(sizes);
      while (value.bytes.size() < size) value.u32(dice_->once_in(2) ? dice_->below(4) : edge());
    }
  }
  value.align();
  return value.bytes;
}

void Grammar::put_parameter(Body& body, std::uint32_t parameter) {
  Octets value = value_of(parameter, body.little);
  std::size_t size = value.size();
  if (breaks(Rule::parameter_size_odd)) {
    value.resize(size + 4);
    size += 1 + dice_->below(3);
    value.resize(size);
    parameter = 0x8007;  // a parameter that may have any content
  } else if (breaks(Rule::parameter_too_long)) {
    size = 0xfffc;
    parameter = 0x8007;
  }
  if (dice_->once_in(16) && parameter != 0) parameter |= 0x4000U;
  body.u16(parameter).u16(size).add(value);
}

void Grammar::put_end(Body& body) {
  if (breaks(Rule::list_without_end)) {
    if (dice_->once_in(2)) body.zeros(dice_->below(4));  // an incomplete head
    return;
  }
  body.u16(1).u16(dice_->once_in(8) ? edge() : 0);
}

std::uint32_t Grammar::discovery_parameter() {
  const auto one_of = [&](std::initializer_list<std::uint32_t> all) {
    return *(all.begin() + dice_->below(all.size()));
  };
  switch (target_) {
    case Rule::text_too_long:
    case Rule::text_without_end:
    case Rule::text_missing:
      return one_of({0x05, 0x07, 0x62});
    case Rule::texts_too_many:
    case Rule::texts_empty_one:
      return 0x29;
    case Rule::properties_too_many:
    case Rule::binary_properties_too_many:
    case Rule::binary_property_too_long:
      return 0x59;
    case Rule::token_class_too_long:
    case Rule::token_too_many_properties:
    case Rule::token_too_many_binary_properties:
    case Rule::token_binary_too_long:
      return one_of({0x1001, 0x1002});
    case Rule::octets_too_long:
      return one_of({0x2c, 0x2d, 0x2e});
    case Rule::locator_size:
      return one_of({0x2f, 0x30, 0x31, 0x32, 0x33, 0x48});
    case Rule::guid_size:
      return one_of({0x50, 0x52, 0x5a, 0x70});
    case Rule::number_size:
      return one_of({0x58, 0x71, 0x77});
    case Rule::shorts_too_many:
      return 0x73;
    case Rule::longs_too_many:
      return 0x8006;
    case Rule::filter_text_too_long:
    case Rule::filter_too_many:
      return 0x35;
    default:
      return dice_->of(all_parameters());
  }
}

Octets Grammar::parameters(bool is_little) {
  Body list{is_little};
  if (target_ == Rule::none && dice_->once_in(3)) put_parameter(list, 0x70);  // the key hash of a sample
  for (std::uint64_t n = 1 + dice_->below(4); n > 0; --n) put_parameter(list, discovery_parameter());
  put_end(list);
  return list.bytes;
}

// An announcement of the sender, with up to two more or changed parameters.
Octets Grammar::announcement(bool is_little) {
  const bool secured = !certificate_.empty();
  Body list{is_little};
  const auto put = [&](std::uint32_t parameter, const Body& value) {
    list.u16(parameter).u16(value.bytes.size()).add(value.bytes);
  };
  const auto body = [&] { return Body{is_little}; };
  const auto guid_of = [&](const Prefix& of) {
    return body().add({of.begin(), of.end()}).id(kParticipantId);
  };
  const auto locator = [&] { return body().u32(1).u32(ports_.peers).zeros(12).add({127, 0, 0, 1}); };
  Prefix other = from_;
  other[10] = 0x55;
  put(0x15, body().u8(2).u8(3).zeros(2));
  put(0x16, body().u8(1).u8(15).zeros(2));
  const bool without_guid = breaks(Rule::announces_without_guid);
  const bool of_nobody = breaks(Rule::announces_nobody);
  if (!without_guid)
    put(0x50, guid_of(of_nobody ? Prefix{} : breaks(Rule::announces_another) ? other : from_));
  if (breaks(Rule::announces_key_of_another)) put(0x70, guid_of(other));
  std::uint64_t lease = secured ? 1 + dice_->below(100) : dice_->once_in(8) ? dice_->below(3) : 0x7fffffff;
  if (breaks(Rule::announces_no_lease)) lease = 0;
  if (breaks(Rule::announces_long_lease)) lease = 101 + dice_->below(0xffffff00);
  put(0x02, body().u32(lease).u32(0));
  put(0x31, locator());
  put(0x32, locator());
  put(0x58, body().u32(0x0c3f | (secured ? 0x0fff0000U : 0)));
  if (dice_->once_in(8)) put(0x62, body().text(words()));
  // With DDS Security, no parameter may name another participant, or a lease that is too long.
  for (std::uint64_t n = dice_->below(3); n > 0; --n) {
    const std::uint32_t parameter = discovery_parameter();
    const std::uint32_t named = parameter & ~0x4000U;
    if (!(secured || without_guid) || (named != 0x50 && named != 0x70 && named != 0x02) ||
        target_ == Rule::guid_size)
      put_parameter(list, parameter);
  }
  put_end(list);
  return list.bytes;
}

Octets Grammar::endpoint(bool is_little, const Endpoint& of, bool writes, const Prefix& peer) {
  Body list{is_little};
  const auto put = [&](std::uint32_t parameter, const Body& value) {
    list.u16(parameter).u16(value.bytes.size()).add(value.bytes);
  };
  const auto body = [&] { return Body{is_little}; };
  put(0x5a, body().add({peer.begin(), peer.end()}).id(of.id));
  put(0x50, body().add({peer.begin(), peer.end()}).id(kParticipantId));
  put(0x05, body().text(of.topic));
  put(0x07, body().text(of.type));
  put(0x1a, body().u32(of.reliable ? 2 : 1).u32(0).u32(429496729));
  put(0x1d, body().u32(of.kept ? 1 : 0));
  if (writes) put(0x1b, body().u32(2).u32(0).u32(1u << 28));  // a lease of 62.5 ms, by topic
  return list.bytes;
}

// ---- Submessages

Grammar::Part Grammar::part(std::uint8_t kind, unsigned flags, Body body) const {
  return {kind, static_cast<std::uint8_t>(flags | (body.little ? 1U : 0U)), std::move(body.bytes)};
}

void Grammar::put_ids(Body& body, bool to_reader) {
  if (dice_->once_in(2)) {
    port_ = ports_.discovery;
    const std::uint32_t writer = dice_->of(builtin_writers());
    const std::uint32_t reader = builtin_reader(writer);
    body.id(to_reader && dice_->once_in(3) ? 0 : reader).id(writer);
    return;
  }
  port_ = ports_.samples;
  const std::size_t at = to_reader ? any_reader() : dice_->below(writers_.size());
  const auto place = static_cast<std::uint32_t>(at);
  const Endpoint& own = to_reader ? readers_[at] : writers_[at];
  const bool keyed = (own.id & 0xffU) == 0x07 || (own.id & 0xffU) == 0x02;
  if (to_reader)
    body.id(dice_->once_in(3) ? 0 : own.id).id((0x100U + place) << 8U | (keyed ? 2U : 3U));
  else
    body.id((0x200U + place) << 8U | (keyed ? 7U : 4U)).id(own.id);
}

namespace {

/// The entity ids of a body that begins with them: of the reader and of the writer.
std::uint32_t id_at(const Octets& bytes, std::size_t at) {
  std::uint32_t id = 0;
  for (std::size_t i = 0; i < 4; ++i) id = id << 8U | bytes[at + i];
  return id;
}

}  // namespace

void Grammar::put_set(Body& body, std::uint32_t least) {
  static const std::vector<std::uint32_t> counts{0, 1, 2, 8, 31, 32, 33, 64, 255, 256};
  if (breaks(Rule::set_too_many_bits)) {
    const std::uint32_t n = dice_->once_in(2) ? 257 : dice_->of(too_many());
    body.u32(n).add(random(36));
    return;
  }
  std::uint32_t n = std::max(least, dice_->of(counts));
  const bool cut = breaks(Rule::set_cut);
  if (cut) n = std::max(n, 96U);
  body.u32(n).add(random((n + 31) / 32 * 4 - (cut ? 4 + 4 * dice_->below(2) + (n == 256 ? 4 : 0) : 0)));
}

Octets Grammar::head(bool is_little, std::uint32_t writer, bool fragment, std::size_t skipped) {
  const Rule number_low = fragment ? Rule::fragment_number_low : Rule::data_number_low;
  const Rule number_high = fragment ? Rule::fragment_number_high : Rule::data_number_high;
  std::uint32_t reader = builtin_reader(writer);
  if (!is_builtin(writer)) {
    const std::uint32_t place = (writer >> 8U) - 0x100;
    reader = place < readers_.size() ? readers_[place].id : 0;
  }
  std::int64_t& next = next_.try_emplace({from_, writer}, 1).first->second;
  std::int64_t number = number_near(next);
  // Often a fragment and a later sample or fragment have the same number.
  std::int64_t& of_fragment = of_fragment_.try_emplace({from_, writer}, number).first->second;
  if (dice_->once_in(3)) number = of_fragment;
  if (fragment) of_fragment = number;
  if (advances_ && number == next) ++next;
  if (breaks(number_low)) number = low();
  if (breaks(number_high)) number = high();
  Body body{is_little};
  body.u16(dice_->once_in(8) ? edge() : 0).u16((fragment ? 28 : 16) + skipped);
  body.id(dice_->once_in(3) ? 0 : reader).id(writer).number(number);
  port_ = is_builtin(writer) ? ports_.discovery : ports_.samples;
  return body.bytes;
}

Grammar::Parts Grammar::data() {
  const bool is_little = little();
  const std::size_t place = any_reader();
  const Endpoint& own = readers_[place];
  const std::uint32_t writer =
      (0x100U + static_cast<std::uint32_t>(place)) << 8U | ((own.id & 0xffU) == 7 ? 2U : 3U);
  std::size_t skipped = dice_->once_in(8) ? 4 * dice_->below(4) : 0;
  if (breaks(Rule::data_offset_negative)) skipped = 0x8000 - 16 + dice_->below(64);
  Body body{is_little};
  body.bytes = head(is_little, writer, false, skipped);
  body.zeros(skipped);
  static const std::vector<unsigned> kinds{4, 4, 4, 4, 6, 6, 8, 10, 0, 2, 0x14};
  unsigned flags = dice_->of(kinds);
  if (breaks(Rule::data_with_key)) flags = 0x0c;
  if (target_ == Rule::list_without_end) flags = 2;
  if (breaks(Rule::data_without_encapsulation)) {
    body.add(random(dice_->below(4)));
    return {part(kData, dice_->once_in(2) ? 4 : 8, body)};
  }
  if ((flags & 2U) != 0) body.add(parameters(is_little));
  if ((flags & 0x0cU) != 0) {
    if (!own.samples.empty() && !dice_->once_in(4)) {
      Octets sample = dice_->of(own.samples);
      if (dice_->once_in(4)) sample.resize(4 + dice_->below(sample.size()));
      for (std::uint64_t n = dice_->once_in(2) ? dice_->below(3) : 0; n > 0 && sample.size() > 4; --n)
        sample[4 + dice_->below(sample.size() - 4)] = static_cast<std::uint8_t>(edge());
      body.add(sample);
    } else {
      body.add(random(4 + dice_->below(dice_->once_in(16) ? 8000 : 80)));
    }
  }
  if (target_ == Rule::data_offset_beyond) body.bytes.resize(std::min<std::size_t>(body.bytes.size(), 600));
  if (breaks(Rule::data_offset_low) || breaks(Rule::data_offset_beyond)) {
    Body offset{is_little};
    offset.u16(target_ == Rule::data_offset_low ? dice_->below(16)
                                                : body.bytes.size() - 3 + dice_->below(64));
    std::copy(offset.bytes.begin(), offset.bytes.end(), body.bytes.begin() + 2);
  }
  if (breaks(Rule::fixed_part_cut)) {
    body.bytes.resize(1 + dice_->below(19));
    flags = 0;
  }
  return {part(kData, flags, body)};
}

Grammar::Parts Grammar::discovery() {
  static const std::vector<std::uint32_t> writers{kParticipants,  kPublications,  kPublications,
                                                  kSubscriptions, kSubscriptions, kTopics};
  const std::uint32_t writer = dice_->of(writers);
  if (writer == kParticipants) return announcing();
  const bool is_little = little();
  Body body{is_little};
  body.bytes = head(is_little, writer, false, 0);
  unsigned flags = dice_->once_in(8) ? 8 : 4;
  if (dice_->once_in(3) && target_ != Rule::list_without_end) {
    flags |= 2;
    body.add(parameters(is_little));
  }
  const bool content_is_little = little();
  const std::uint64_t order = content_is_little ? 3 : 2;
  std::uint64_t encapsulation = order;
  if (breaks(Rule::discovery_encapsulation)) {
    static const std::vector<std::uint64_t> others{0, 1, 4, 5, 6, 7, 255, 128};
    encapsulation = dice_->of(others);
  }
  body.u8(breaks(Rule::discovery_encapsulation_high) ? 1 + dice_->below(255) : 0)
      .u8(encapsulation)
      .u16(edge());
  Body list{content_is_little};
  if (writer == kPublications || writer == kSubscriptions) {
    const bool writes = writer == kPublications;
    const std::vector<Endpoint>& own = writes ? readers_ : writers_;
    Endpoint one = dice_->of(own);
    const auto place = static_cast<std::uint32_t>(dice_->below(own.size() + 4));
    const bool keyed = (one.id & 0xffU) == 7 || (one.id & 0xffU) == 2;
    one.id = ((writes ? 0x100U : 0x200U) + place) << 8U | (writes ? (keyed ? 2U : 3U) : (keyed ? 7U : 4U));
    list.bytes = endpoint(content_is_little, one, writes, from_);
  }
  list.add(parameters(content_is_little));
  body.add(list.bytes);
  return {part(kData, flags, body)};
}

Grammar::Parts Grammar::announcing() {
  const bool is_little = little();
  const auto make = [&] {
    Body body{is_little};
    body.bytes = head(is_little, kParticipants, false, 0);
    body.u8(0).u8(is_little ? 3 : 2).u16(0).add(announcement(is_little));
    return part(kData, 4, body);
  };
  if (!breaks(Rule::announces_twice)) return {make()};
  return {make(), make()};
}

Grammar::Parts Grammar::proof() {
  const bool is_little = little();
  Body body{is_little};
  body.bytes = head(is_little, kProofs, false, 0);
  static const std::vector<std::uint64_t> others{2, 3, 4, 255};
  const bool content_is_little = little();
  body.u8(breaks(Rule::proof_encapsulation_high) ? 1 + dice_->below(255) : 0);
  body.u8(breaks(Rule::proof_encapsulation) ? dice_->of(others) : content_is_little ? 1 : 0).u16(0);
  Body message{content_is_little};
  const auto guid = [&](const Prefix& of, std::uint32_t id) { message.add({of.begin(), of.end()}).id(id); };
  guid(from_, kProofs);
  message.number(static_cast<std::int64_t>(edge()));
  guid(mine_, kProofs);
  message.number(static_cast<std::int64_t>(edge()));
  guid(dice_->once_in(4) ? from_ : mine_, kParticipantId);
  guid(dice_->once_in(2) ? Prefix{} : mine_, 0);
  guid(from_, 0);
  if (breaks(Rule::proof_cut)) {
    message.bytes.resize(dice_->below(100));
    return {part(kData, 4, body.add(message.bytes))};
  }
  static const std::vector<std::string> classes{"dds.sec.auth", "dds.sec.auth_request",
                                                "dds.sec.participant_crypto_tokens",
                                                "dds.sec.datawriter_crypto_tokens"};
  if (breaks(Rule::proof_class_too_long))
    message.u32(dice_->of(too_many())).add(random(16));
  else
    message.text(dice_->of(classes));
  auto tokens = static_cast<std::uint32_t>(dice_->below(3));
  if (target_ == Rule::proof_token_too_long || target_ == Rule::proof_of_nobody) ++tokens;
  message.u32(breaks(Rule::proof_too_many_tokens) ? (dice_->once_in(2) ? tokens + 1 : dice_->of(too_many()))
                                                  : tokens);
  for (std::uint32_t i = 0; i < tokens; ++i) put_token(message, true);
  return {part(kData, 4, body.add(message.bytes))};
}

Grammar::Parts Grammar::fragment() {
  const bool is_little = little();
  const std::size_t place = any_reader();
  const Endpoint& own = readers_[place];
  std::uint32_t writer =
      (0x100U + static_cast<std::uint32_t>(place)) << 8U | ((own.id & 0xffU) == 7 ? 2U : 3U);
  if ((!certificate_.empty() || dice_->once_in(8)) && target_ != Rule::unprotected_fragment) writer = kProofs;
  if (breaks(Rule::fragment_of_long_proof)) writer = kProofs;
  if (breaks(Rule::fragment_of_discovery)) {
    static const std::vector<std::uint32_t> all{kParticipants, kPublications, kSubscriptions, kTopics};
    writer = dice_->of(all);
  }
  breaks(Rule::unprotected_fragment);
  std::size_t skipped = dice_->once_in(8) ? 4 * dice_->below(4) : 0;
  if (breaks(Rule::fragment_offset_negative)) skipped = 0x8000 - 28 + dice_->below(64);
  Body body{is_little};
  body.bytes = head(is_little, writer, true, skipped);

  // Usually the sizes depend only on the writer, so that fragments of one sample complete each other.
  Octets sample = own.samples.empty() ? random(100) : own.samples[writer / 7 % own.samples.size()];
  static const std::vector<std::uint64_t> sizes{1, 3, 4, 5, 16, 64, 1000, 1344};
  std::uint64_t size = dice_->once_in(8) ? dice_->of(sizes) : 4 + sample.size() / 3;
  std::uint64_t whole = sample.size();
  if (writer == kProofs && target_ == Rule::none && dice_->once_in(2)) {
    // The filter cannot check an authentication message of which it sees only fragments.
    static const std::vector<Rule> rules{Rule::none,
                                         Rule::proof_class_too_long,
                                         Rule::proof_too_many_tokens,
                                         Rule::token_too_many_binary_properties,
                                         Rule::token_binary_too_long,
                                         Rule::proof_cut};
    target_ = dice_->of(rules);
    const Octets message = proof().front().body;
    target_ = Rule::none;
    broken_ = false;
    sample.assign(message.begin() + 20, message.end());
    whole = size = sample.size();
  } else if (dice_->once_in(10)) {
    whole = std::max<std::uint64_t>(1, edge() & (dice_->once_in(8) ? 0xffffffffU : 0xffffU));
    size = std::max<std::uint64_t>(1, edge() & 0x7ffU);
  }
  if (writer == kProofs) whole = std::min<std::uint64_t>(whole, 65535);
  // The number of a fragment behind the sample must not overflow.
  if (target_ == Rule::fragment_begins_behind || target_ == Rule::fragment_ends_behind)
    whole = std::min<std::uint64_t>(whole, 0xffffff00);
  if (target_ == Rule::fragment_of_long_proof) whole = 65536 + dice_->below(100000), size = 500;
  const std::uint64_t fragments = (whole + size - 1) / size;
  std::uint64_t first = 1 + dice_->below(fragments);
  std::uint64_t count = 1 + dice_->below(std::min<std::uint64_t>(
                                {fragments - first + 1, 0xffff, std::max<std::uint64_t>(1, 20000 / size)}));
  std::uint64_t content = std::min(count * size, whole - (first - 1) * size);
  if (breaks(Rule::fragment_first_0)) first = 0;
  if (breaks(Rule::fragment_begins_behind)) first = fragments + 1 + dice_->below(3);
  if (breaks(Rule::fragment_ends_behind)) {
    first = fragments - dice_->below(std::min<std::uint64_t>(fragments, 3));
    count = fragments - first + 2 + dice_->below(3);
    content = whole - (first - 1) * size;
  }
  if (breaks(Rule::fragment_count_0)) count = 0;
  if (breaks(Rule::fragment_content_cut)) content -= 1 + dice_->below(content);
  const std::uint64_t begin = std::min<std::uint64_t>(first == 0 ? 0 : (first - 1) * size, sample.size());
  body.u32(first).u16(count).u16(breaks(Rule::fragment_size_0) ? 0 : size);
  body.u32(breaks(Rule::fragment_sample_0) ? 0 : whole);
  body.zeros(skipped);
  unsigned flags = dice_->once_in(6) ? 2 : 0;
  if (target_ == Rule::list_without_end || target_ == Rule::fixed_part_cut) flags = 0;
  if (breaks(Rule::fragment_of_key)) flags |= 4U;
  if (breaks(Rule::fixed_part_cut))
    cut(body, 31);
  else {
    if ((flags & 2U) != 0) body.add(parameters(is_little));
    Octets bytes{sample.begin() + static_cast<std::ptrdiff_t>(begin), sample.end()};
    bytes.resize(content);
    body.add(bytes);
  }
  if (target_ == Rule::fragment_offset_beyond)
    body.bytes.resize(std::min<std::size_t>(body.bytes.size(), 600));
  if (breaks(Rule::fragment_offset_low) || breaks(Rule::fragment_offset_beyond)) {
    Body offset{is_little};
    offset.u16(target_ == Rule::fragment_offset_low ? dice_->below(28)
                                                    : body.bytes.size() - 3 + dice_->below(64));
    std::copy(offset.bytes.begin(), offset.bytes.end(), body.bytes.begin() + 2);
  }
  return {part(kDataFrag, flags, body)};
}

Grammar::Parts Grammar::heartbeat() {
  Body body{little()};
  put_ids(body, true);
  std::int64_t& next = next_.try_emplace({from_, id_at(body.bytes, 4)}, 1).first->second;
  std::int64_t first = std::max<std::int64_t>(1, number_near(dice_->once_in(2) ? 1 : next));
  std::int64_t last = std::clamp(number_near(next), first - 1, kMost);
  if (advances_) next = std::max(next, first);
  if (breaks(Rule::heartbeat_first_low)) first = low(), last = std::max<std::int64_t>(last, 0);
  if (breaks(Rule::heartbeat_first_high)) first = last = high();
  if (breaks(Rule::heartbeat_last_high)) last = high();
  if (breaks(Rule::heartbeat_last_low)) first = std::max<std::int64_t>(first, 2), last = first - 2;
  if (breaks(Rule::heartbeat_last_negative))
    first = 1, last = -1 - static_cast<std::int64_t>(dice_->below(3));
  body.number(first).number(last).u32(dice_->once_in(64) ? edge() : ++count_);
  if (breaks(Rule::fixed_part_cut)) cut(body, 27);
  return {part(kHeartbeat, static_cast<unsigned>(dice_->below(4) << 1U), body)};
}

Grammar::Parts Grammar::acknack() {
  Body body{little()};
  put_ids(body, false);
  std::int64_t base = dice_->once_in(4) ? 0 : number_near(static_cast<std::int64_t>(1 + dice_->below(8)));
  if (breaks(Rule::acknack_base_negative)) base = std::min<std::int64_t>(low(), -1);
  if (breaks(Rule::acknack_base_high)) base = high();
  body.number(base);
  put_set(body, 0);
  if (target_ != Rule::set_cut && !breaks(Rule::count_missing))
    body.u32(dice_->once_in(64) ? edge() : ++count_);
  if (breaks(Rule::fixed_part_cut)) cut(body, 19);
  return {part(kAcknack, static_cast<unsigned>(dice_->below(2) << 1U), body)};
}

Grammar::Parts Grammar::gap() {
  Body body{little()};
  put_ids(body, true);
  std::int64_t& next = next_.try_emplace({from_, id_at(body.bytes, 4)}, 1).first->second;
  std::int64_t start = number_near(next);
  std::int64_t base = std::max(start, number_near(start));
  if (advances_ && start <= next) next = std::max(next, base);
  if (breaks(Rule::gap_start_low)) start = low();
  if (breaks(Rule::gap_start_high)) start = base = high();
  if (breaks(Rule::gap_base_high)) base = high();
  if (breaks(Rule::gap_base_before_start)) start = std::max<std::int64_t>(start, 2), base = start - 1;
  body.number(start).number(base);
  put_set(body, 0);
  if (breaks(Rule::fixed_part_cut)) cut(body, 27);
  return {part(kGap, 0, body)};
}

Grammar::Parts Grammar::nack_frag() {
  Body body{little()};
  put_ids(body, false);
  std::int64_t number = number_near(static_cast<std::int64_t>(1 + dice_->below(8)));
  if (breaks(Rule::nack_frag_number_low)) number = low();
  if (breaks(Rule::nack_frag_number_high)) number = high();
  constexpr std::uint64_t kMostBase = 0xfffffeff;
  std::uint64_t base = std::clamp<std::uint64_t>(edge() & 0xffffffffU, 1, kMostBase);
  if (breaks(Rule::nack_frag_base_0)) base = 0;
  if (breaks(Rule::nack_frag_base_high)) base = kMostBase + 1 + dice_->below(256);
  body.number(number).u32(base);
  put_set(body, 0);
  if (target_ != Rule::set_cut && !breaks(Rule::count_missing)) body.u32(++count_);
  if (breaks(Rule::fixed_part_cut)) cut(body, 23);
  return {part(kNackFrag, 0, body)};
}

Grammar::Parts Grammar::heartbeat_frag() {
  Body body{little()};
  put_ids(body, true);
  std::int64_t number = number_near(next_.try_emplace({from_, id_at(body.bytes, 4)}, 1).first->second);
  if (breaks(Rule::heartbeat_frag_number_low)) number = low();
  if (breaks(Rule::heartbeat_frag_number_high)) number = high();
  body.number(number)
      .u32(breaks(Rule::heartbeat_frag_last_0) ? 0 : std::max<std::uint64_t>(1, edge() & 0xffffffffU))
      .u32(++count_);
  if (breaks(Rule::fixed_part_cut)) cut(body, 23);
  return {part(kHeartbeatFrag, 0, body)};
}

Grammar::Parts Grammar::info() {
  Body body{little()};
  std::size_t size = 0;
  std::uint8_t kind = 0;
  unsigned flags = 0;
  switch (dice_->below(5)) {
    case 0:
      kind = kInfoTs, size = 8;
      if (dice_->once_in(4) && target_ != Rule::fixed_part_cut) flags = 2, size = 0;
      body.add(random(size));
      break;
    case 1:
      kind = kInfoSrc, size = 20;
      body.zeros(4).u8(2).u8(3).u16(0x010f).add({from_.begin(), from_.end()});
      break;
    case 2: {
      kind = kInfoDst, size = 12;
      const Prefix& to = dice_->once_in(4) ? from_ : mine_;
      body.add(dice_->once_in(2) ? Octets(12) : Octets{to.begin(), to.end()});
      break;
    }
    case 3:
      kind = kInfoReplyIp4, flags = dice_->once_in(2) ? 2 : 0, size = flags != 0 ? 16 : 8;
      body.add(random(size));
      break;
    default:
      kind = kPad, size = 4 * dice_->below(4);
      body.zeros(size);
      if (target_ == Rule::fixed_part_cut) kind = kInfoDst, size = 12;
  }
  if (!certificate_.empty() && (kind == kInfoSrc || kind == kInfoReplyIp4)) {
    kind = kInfoDst;
    body.bytes.assign(size = 12, 0);
  }
  if (breaks(Rule::fixed_part_cut)) cut(body, size - 1);
  return {part(kind, flags, body)};
}

Grammar::Parts Grammar::reply() {
  Body body{little()};
  const auto put = [&](Rule rule) {
    const auto n = static_cast<std::uint32_t>(dice_->below(3));
    if (breaks(rule)) {
      body.u32(dice_->once_in(2) ? n + 1 : dice_->of(too_many())).add(random(24 * n));
      return false;
    }
    body.u32(n).add(random(24 * n));
    return true;
  };
  unsigned flags = dice_->once_in(2) ? 2 : 0;
  if (target_ == Rule::reply_second_locators) flags = 2;
  if (target_ == Rule::reply_locators) flags = 0;
  put(Rule::reply_locators);
  if (flags != 0) put(Rule::reply_second_locators);
  return {part(kInfoReply, flags, body)};
}

// Submessages of DDS Security in any order, of vendors, and of kinds that nobody has defined.
Grammar::Parts Grammar::other() {
  Body body{little()};
  const auto readers = static_cast<std::uint32_t>(dice_->below(3));
  std::uint64_t which = dice_->below(6);
  if (target_ == Rule::fixed_part_cut) which = 1;
  if (target_ == Rule::body_size) which = 0;
  if (target_ == Rule::postfix_readers) which = 2;
  switch (which) {
    case 0: {
      const Octets content = random(dice_->below(64));
      body.id(static_cast<std::uint32_t>(breaks(Rule::body_size) ? content.size() + 1 + dice_->below(9)
                                                                 : content.size()));
      if (target_ == Rule::body_size && dice_->once_in(2)) body.bytes.clear(), body.id(dice_->of(too_many()));
      body.add(content);
      return {part(kSecBody, 0, body)};
    }
    case 1:
      body.add(random(20));
      if (breaks(Rule::fixed_part_cut)) cut(body, 19);
      return {part(dice_->once_in(2) ? kSecPrefix : kSrtpsPrefix, 0, body)};
    case 2:
      body.add(random(16))
          .id(breaks(Rule::postfix_readers) ? (dice_->once_in(2) ? readers + 1 : dice_->of(too_many()))
                                            : readers);
      body.add(random(20 * readers));
      return {part(dice_->once_in(2) ? kSecPostfix : kSrtpsPostfix, 0, body)};
    case 3:
      body.add(random(1 + dice_->below(40)));
      return {part(static_cast<std::uint8_t>(0x81 + dice_->below(0x7f)),
                   static_cast<unsigned>(dice_->below(128) << 1U), body)};
    default: {
      static const std::vector<std::uint8_t> unknown{0x02, 0x03, 0x05, 0x0a, 0x0b, 0x10,
                                                     0x14, 0x17, 0x2f, 0x35, 0x7f};
      body.add(random(1 + dice_->below(40)));
      return {part(dice_->of(unknown), static_cast<unsigned>(dice_->below(128) << 1U), body)};
    }
  }
}

// The prefix, body and postfix of DDS Security around some submessages, or around the whole message.
Grammar::Parts Grammar::protect(std::uint8_t prefix_kind) {
  port_ = dice_->once_in(2) ? ports_.discovery : ports_.samples;
  Body prefix{little()};
  prefix.zeros(3).u8(dice_->below(5)).add(random(16));
  if (breaks(Rule::prefix_size)) prefix.add(random(4 * (1 + dice_->below(2))));
  const Octets content = random(12 + dice_->below(80));
  Body body{little()};
  body.id(static_cast<std::uint32_t>(content.size() -
                                     (breaks(Rule::prefix_body_size) ? 4 + dice_->below(8) : 0)));
  body.add(content);
  const auto readers = static_cast<std::uint32_t>(dice_->below(3));
  Body postfix{little()};
  postfix.add(random(16)).id(readers).add(random(20 * readers));
  if (breaks(Rule::postfix_size)) postfix.add(random(4 * (1 + dice_->below(4))));
  Parts parts{part(prefix_kind, 0, prefix), part(kSecBody, 0, body)};
  if (breaks(Rule::prefix_without_body)) parts[1].kind = dice_->once_in(2) ? kPad : 0x81;
  const bool is_whole = (prefix_kind == kSrtpsPrefix) != breaks(Rule::prefix_wrong_postfix);
  if (!breaks(Rule::prefix_without_postfix))
    parts.push_back(part(is_whole ? kSrtpsPostfix : kSecPostfix, 0, postfix));
  return parts;
}

Grammar::Parts Grammar::protected_parts() { return protect(kSecPrefix); }

Grammar::Parts Grammar::protected_whole() {
  Parts parts = protect(kSrtpsPrefix);
  const Parts more = info();
  if (breaks(Rule::whole_prefix_not_first)) parts.insert(parts.begin(), more.begin(), more.end());
  if (breaks(Rule::whole_not_alone)) parts.insert(parts.end(), more.begin(), more.end());
  return parts;
}

// ---- Messages

Grammar::Make Grammar::maker_of(Rule rule) const {
  const auto among = [&](std::initializer_list<Make> all) {
    return *(all.begin() + dice_->below(all.size()));
  };
  const auto between = [rule](Rule first, Rule last) { return first <= rule && rule <= last; };
  using G = Grammar;
  if (rule == Rule::fixed_part_cut)
    return among({&G::data, &G::fragment, &G::heartbeat, &G::acknack, &G::gap, &G::nack_frag,
                  &G::heartbeat_frag, &G::info, &G::other});
  if (between(Rule::heartbeat_first_low, Rule::heartbeat_last_negative)) return &G::heartbeat;
  if (between(Rule::acknack_base_negative, Rule::acknack_base_high)) return &G::acknack;
  if (between(Rule::set_too_many_bits, Rule::set_cut)) return among({&G::acknack, &G::gap, &G::nack_frag});
  if (rule == Rule::count_missing) return among({&G::acknack, &G::nack_frag});
  if (between(Rule::gap_start_low, Rule::gap_base_high)) return &G::gap;
  if (between(Rule::nack_frag_number_low, Rule::nack_frag_base_0)) return &G::nack_frag;
  if (between(Rule::heartbeat_frag_number_low, Rule::heartbeat_frag_last_0)) return &G::heartbeat_frag;
  if (between(Rule::reply_locators, Rule::reply_second_locators)) return &G::reply;
  if (between(Rule::body_size, Rule::postfix_readers)) return &G::other;
  if (between(Rule::data_offset_low, Rule::data_without_encapsulation)) return &G::data;
  if (between(Rule::fragment_of_discovery, Rule::fragment_content_cut) || rule == Rule::unprotected_fragment)
    return &G::fragment;
  if (between(Rule::list_without_end, Rule::parameter_too_long))
    return among({&G::discovery, &G::data, &G::announcing});
  if (between(Rule::discovery_encapsulation, Rule::discovery_encapsulation_high) ||
      between(Rule::text_too_long, Rule::filter_too_many))
    return &G::discovery;
  if (between(Rule::proof_encapsulation, Rule::proof_of_nobody)) return &G::proof;
  if (rule == Rule::unprotected_sample) return &G::data;
  if (rule == Rule::unprotected_submessage)
    return among({&G::heartbeat, &G::acknack, &G::gap, &G::nack_frag, &G::heartbeat_frag, &G::reply});
  if (between(Rule::prefix_size, Rule::postfix_without_length))
    return among({&G::protected_parts, &G::protected_whole});
  if (between(Rule::whole_prefix_not_first, Rule::whole_not_alone)) return &G::protected_whole;
  if (between(Rule::announces_another, Rule::announces_long_lease) ||
      between(Rule::announces_without_guid, Rule::announces_nobody))
    return &G::announcing;
  if (!certificate_.empty())
    return among({&G::protected_parts, &G::protected_parts, &G::announcing, &G::proof, &G::fragment});
  return among({&G::data, &G::data, &G::discovery, &G::discovery, &G::announcing, &G::proof, &G::fragment,
                &G::fragment, &G::heartbeat, &G::heartbeat, &G::acknack, &G::acknack, &G::gap, &G::nack_frag,
                &G::heartbeat_frag, &G::info, &G::reply, &G::other});
}

Octets Grammar::message(const Parts& parts) {
  Octets bytes{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  bytes.insert(bytes.end(), from_.begin(), from_.end());
  if (breaks(Rule::header_name)) ++bytes[dice_->below(4)];
  if (breaks(Rule::header_version)) bytes[4] = static_cast<std::uint8_t>(dice_->once_in(2) ? 1 : 3);
  for (const Part& each : parts) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    const bool last = &each == &parts.back();
    std::size_t length = each.body.size();
    if (last && length > 0 && each.kind != kPad && each.kind != kInfoTs && certificate_.empty() &&
        target_ == Rule::none && dice_->once_in(8))
      length = 0;  // extends to the end
    if (last && breaks(Rule::postfix_without_length)) length = 0;
    if (last && breaks(Rule::submessage_too_long))
      length =
          std::min<std::size_t>(0xffff, each.body.size() + 1 + dice_->below(dice_->once_in(2) ? 4 : 0x10000));
    Body head{(each.flags & 1U) != 0};
    head.u8(each.kind).u8(each.flags).u16(length);
    bytes.insert(bytes.end(), head.bytes.begin(), head.bytes.end());
    bytes.insert(bytes.end(), each.body.begin(), each.body.end());
  }
  if (breaks(Rule::submessage_head_cut)) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    bytes.resize(bytes.size() + 1 + dice_->below(3), 1);
  }
  if (breaks(Rule::no_submessage)) {
    bytes.resize(20);
    if (dice_->once_in(2)) bytes.insert(bytes.end(), {kStatistics, 1, 4, 0, 0, 0, 0, 0});
  }
  if (breaks(Rule::header_short)) bytes.resize(dice_->below(20));
  return bytes;
}

void Grammar::damage(Octets& bytes) {
  for (std::uint64_t n = 1 + dice_->below(2); n > 0 && bytes.size() > 20; --n) {
    const auto at = static_cast<std::ptrdiff_t>(20 + dice_->below(bytes.size() - 20));
    const auto here = bytes.begin() + at;
    switch (dice_->below(7)) {
      case 0:
        *here ^= static_cast<std::uint8_t>(1U << dice_->below(8));
        break;
      case 1:
        *here = static_cast<std::uint8_t>(edge());
        break;
      case 2:
        bytes.erase(here, bytes.end());
        break;
      case 3:
        bytes.erase(here, here + std::min<std::ptrdiff_t>(bytes.end() - here,
                                                          static_cast<std::ptrdiff_t>(1 + dice_->below(8))));
        break;
      case 4: {
        const Octets more = random(1 + dice_->below(8));
        bytes.insert(here, more.begin(), more.end());
        break;
      }
      default: {
        Body number{little()};
        if (dice_->once_in(2))
          number.u16(edge());
        else
          number.u32(edge());
        const std::size_t place = static_cast<std::size_t>(at) / 2 * 2;
        for (std::size_t i = 0; i < number.bytes.size() && place + i < bytes.size(); ++i)
          bytes[place + i] = number.bytes[i];
      }
    }
  }
}

Packet Grammar::packet(Dice& dice) {
  dice_ = &dice;
  const bool secured = !certificate_.empty();
  const std::uint64_t fate = dice.below(10);
  const Rule last = secured ? Rule::count : kSecuredRules;
  for (;;) {
    advances_ = fate < 3;
    if (dice.once_in(100)) {
      favourite_peer_ = dice.below(kPeers);
      favourite_ = dice.below(readers_.size());
    }
    from_ = peer(dice.once_in(2) ? favourite_peer_ : dice.below(kPeers));
    port_ = ports_.discovery;
    broken_ = false;
    target_ = fate < 3 || fate >= 6 ? Rule::none
              : dice.once_in(8)     ? Rule::fixed_part_cut  // a rule of many kinds of submessages
                                    : static_cast<Rule>(1 + dice.below(static_cast<std::uint64_t>(last) - 1));
    const Rule target = target_;
    const bool is_whole = secured && target_ == Rule::none && dice.once_in(4);
    Parts parts;
    const auto append = [&](Parts more) {
      parts.insert(parts.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    };
    const bool alone = is_whole || (Rule::prefix_size <= target_ && target_ <= Rule::whole_not_alone);
    for (std::uint64_t n = alone ? 0 : dice.below(3); n > 0; --n) append(info());
    append(is_whole ? protected_whole() : (this->*maker_of(target_))());
    const std::uint16_t port = port_;
    if (!alone && !secured && dice.once_in(4)) append((this->*maker_of(Rule::none))());
    breaks(Rule::unprotected_sample);
    breaks(Rule::unprotected_submessage);
    if (breaks(Rule::submessage_of_kind_0)) parts.push_back({0, 1, random(8)});
    Packet made;
    made.port = dice.once_in(16) ? ports_.group : port;
    const bool statistics = target == Rule::statistics_not_last || (target == Rule::none && dice.once_in(8));
    if (statistics && !alone) parts.push_back({kStatistics, 1, random(56)});
    if (breaks(Rule::statistics_not_last)) append(info());
    made.bytes = message(parts);
    made.readable = made.bytes.size();
    if (statistics && !alone && target == Rule::none) made.readable -= 60;
    made.kind = broken_ ? Packet::Kind::broken : Packet::Kind::valid;
    made.rule = target;
    if (target != Rule::none && !broken_) continue;  // the packet has no place in which to break this rule
    if (fate >= 6) {
      made.kind = Packet::Kind::damaged;
      damage(made.bytes);
    }
    if (made.bytes.size() > 65000) continue;
    return made;
  }
}

std::vector<Packet> Grammar::introduction(const Prefix& peer) {
  Dice dice{1};
  dice_ = &dice;
  target_ = Rule::none;
  from_ = peer;
  std::erase_if(next_, [&](const auto& each) { return each.first.first == peer; });
  std::vector<Packet> packets;
  const auto add = [&](std::uint32_t writer, unsigned flags, std::int64_t number, const Body& content) {
    Body body{true};
    body.u16(0).u16(16).id(0).id(writer).number(number).add(content.bytes);
    Packet packet;
    packet.bytes = message({part(kData, flags, body)});
    packet.readable = packet.bytes.size();
    packet.port = ports_.discovery;
    packets.push_back(std::move(packet));
  };
  const Octets number_of_it{peer.begin(), peer.end()};
  if (certificate_.empty()) {
    Body ended{true};  // the participant leaves
    ended.u16(0x71)
        .u16(4)
        .u8(0)
        .u8(0)
        .u8(0)
        .u8(3)
        .u16(0x70)
        .u16(16)
        .add(number_of_it)
        .id(kParticipantId)
        .u16(1)
        .u16(0);
    ended.u8(0).u8(3).u16(0).u16(0x50).u16(16).add(number_of_it).id(kParticipantId).u16(1).u16(0);
    add(kParticipants, 10, 1, ended);
  }
  Body found{true};
  found.u8(0).u8(3).u16(0);
  const std::uint32_t lease = certificate_.empty() ? 0x7fffffff : 100;
  found.u16(0x15).u16(4).u8(2).u8(3).u16(0).u16(0x16).u16(4).u8(1).u8(15).u16(0);
  found.u16(0x50).u16(16).add(number_of_it).id(kParticipantId).u16(0x02).u16(8).u32(lease).u32(0);
  for (const std::uint32_t which : {0x31U, 0x32U})
    found.u16(which).u16(24).u32(1).u32(ports_.peers).zeros(12).add({127, 0, 0, 1});
  found.u16(0x58).u16(4).u32(0x0c3f).u16(1).u16(0);
  add(kParticipants, 4, 2, found);
  if (!certificate_.empty()) return packets;
  for (const bool writes : {true, false}) {
    std::uint32_t place = 0;
    for (Endpoint each : writes ? readers_ : writers_) {
      const bool keyed = (each.id & 0xffU) == 7 || (each.id & 0xffU) == 2;
      each.id =
          ((writes ? 0x100U : 0x200U) + place++) << 8U | (writes ? (keyed ? 2U : 3U) : (keyed ? 7U : 4U));
      Body body{true};
      body.u8(0).u8(3).u16(0).add(endpoint(true, each, writes, peer)).u16(1).u16(0);
      add(writes ? kPublications : kSubscriptions, 4, place, body);
    }
    next_[{peer, writes ? kPublications : kSubscriptions}] = place + 1;
  }
  for (Packet& each : packets) each.bytes.shrink_to_fit();
  return packets;
}

Packet Grammar::sample(const Prefix& peer, const std::string& topic, std::int64_t number,
                       const Octets& content) {
  Dice dice{1};
  dice_ = &dice;
  target_ = Rule::none;
  from_ = peer;
  const auto own = std::find_if(readers_.begin(), readers_.end(),
                                [&](const Endpoint& each) { return each.topic == topic; });
  TAKT_CHECK(own != readers_.end());
  const auto place = static_cast<std::uint32_t>(own - readers_.begin());
  Body body{true};
  body.u16(0)
      .u16(16)
      .id(0)
      .id((0x100U + place) << 8U | ((own->id & 0xffU) == 7 ? 2U : 3U))
      .number(number)
      .add(content);
  Packet packet;
  packet.bytes = message({part(kData, 4, body)});
  packet.readable = packet.bytes.size();
  packet.port = ports_.samples;
  return packet;
}

}  // namespace fuzz
