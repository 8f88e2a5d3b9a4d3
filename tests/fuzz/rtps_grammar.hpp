// Makes RTPS packets from the grammar of RTPS 2.3 and DDS Security 1.1, for dds_fuzz. Each packet is valid,
// breaks one named rule, or is damaged somewhere. This is a second statement of the rules in
// framework/wire/src/rtps.cpp: the packet filter must pass the valid packets and drop those that break a
// rule.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fuzz {

using Octets = std::vector<std::uint8_t>;
using Prefix = std::array<std::uint8_t, 12>;

/// Numbers that depend only on the seed.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  std::uint64_t below(std::uint64_t n) { return next() % n; }
  /// True once in n calls.
  bool once_in(std::uint64_t n) { return below(n) == 0; }
  template <class T>
  const T& of(const std::vector<T>& all) {
    return all[below(all.size())];
  }

 private:
  std::uint64_t state_;
};

/// A reader or writer of the participant under test, or one that a peer announces for it.
struct Endpoint {
  std::uint32_t id = 0;
  std::string topic;
  std::string type;
  bool reliable = false;
  bool kept = false;                 ///< transient local
  std::vector<Octets> samples = {};  ///< valid samples of the type
};

/// The rules of rtps.cpp that a packet can break. Those after kSecuredRules apply only with DDS Security.
// clang-format off
#define TAKT_RTPS_RULES(RULE) \
  RULE(header_short) RULE(no_submessage) RULE(header_name) RULE(header_version) \
  RULE(submessage_head_cut) RULE(submessage_too_long) RULE(submessage_of_kind_0) \
  RULE(statistics_not_last) RULE(fixed_part_cut) \
  RULE(heartbeat_first_low) RULE(heartbeat_first_high) RULE(heartbeat_last_low) \
  RULE(heartbeat_last_high) RULE(heartbeat_last_negative) \
  RULE(acknack_base_negative) RULE(acknack_base_high) RULE(set_too_many_bits) RULE(set_cut) \
  RULE(count_missing) \
  RULE(gap_start_low) RULE(gap_start_high) RULE(gap_base_before_start) RULE(gap_base_high) \
  RULE(nack_frag_number_low) RULE(nack_frag_number_high) RULE(nack_frag_base_high) \
  RULE(nack_frag_base_0) \
  RULE(heartbeat_frag_number_low) RULE(heartbeat_frag_number_high) RULE(heartbeat_frag_last_0) \
  RULE(reply_locators) RULE(reply_second_locators) RULE(body_size) RULE(postfix_readers) \
  RULE(data_offset_low) RULE(data_offset_beyond) RULE(data_offset_negative) RULE(data_number_low) \
  RULE(data_number_high) RULE(data_with_key) RULE(data_without_encapsulation) \
  RULE(discovery_encapsulation) RULE(discovery_encapsulation_high) \
  RULE(fragment_of_discovery) RULE(fragment_of_key) RULE(fragment_offset_low) \
  RULE(fragment_offset_beyond) RULE(fragment_offset_negative) RULE(fragment_number_low) \
  RULE(fragment_number_high) RULE(fragment_first_0) RULE(fragment_count_0) RULE(fragment_size_0) \
  RULE(fragment_sample_0) RULE(fragment_of_long_proof) RULE(fragment_begins_behind) \
  RULE(fragment_ends_behind) RULE(fragment_content_cut) RULE(list_without_end) \
  RULE(parameter_size_odd) RULE(parameter_too_long) \
  RULE(text_too_long) RULE(text_without_end) RULE(text_missing) \
  RULE(texts_too_many) RULE(texts_empty_one) RULE(properties_too_many) \
  RULE(binary_properties_too_many) RULE(binary_property_too_long) \
  RULE(token_class_too_long) RULE(token_too_many_properties) RULE(token_too_many_binary_properties) \
  RULE(token_binary_too_long) RULE(octets_too_long) RULE(locator_size) RULE(guid_size) \
  RULE(number_size) RULE(shorts_too_many) RULE(longs_too_many) \
  RULE(filter_text_too_long) RULE(filter_too_many) \
  RULE(announces_without_guid) RULE(announces_nobody) \
  RULE(proof_encapsulation) RULE(proof_encapsulation_high) RULE(proof_cut) RULE(proof_class_too_long) \
  RULE(proof_too_many_tokens) RULE(proof_token_too_long) RULE(proof_of_nobody) \
  RULE(unprotected_submessage) RULE(unprotected_sample) RULE(unprotected_fragment) \
  RULE(prefix_size) RULE(prefix_without_body) RULE(prefix_body_size) RULE(prefix_without_postfix) \
  RULE(prefix_wrong_postfix) RULE(postfix_size) RULE(postfix_without_length) \
  RULE(whole_prefix_not_first) RULE(whole_not_alone) \
  RULE(announces_another) RULE(announces_twice) RULE(announces_key_of_another) \
  RULE(announces_no_lease) RULE(announces_long_lease)
// clang-format on

enum class Rule {
  none,
#define TAKT_NAME(name) name,
  TAKT_RTPS_RULES(TAKT_NAME)
#undef TAKT_NAME
      count
};
const char* to_text(Rule rule);
inline constexpr Rule kSecuredRules = Rule::proof_of_nobody;

struct Packet {
  enum class Kind { valid, broken, damaged };
  Octets bytes;
  Kind kind = Kind::valid;
  Rule rule = Rule::none;    ///< which it breaks
  std::size_t readable = 0;  ///< if it is valid: how many bytes Fast DDS may read
  std::uint16_t port = 0;
};

/// Writes numbers in one byte order.
class Body {
 public:
  explicit Body(bool is_little) : little(is_little) {}
  Body& u8(std::uint64_t value) { return put(value, 1); }
  Body& u16(std::uint64_t value) { return put(value, 2); }
  Body& u32(std::uint64_t value) { return put(value, 4); }
  Body& id(std::uint32_t value);
  Body& number(std::int64_t value);
  Body& zeros(std::size_t n);
  Body& text(const std::string& characters);
  Body& octets(const Octets& content);
  Body& add(const Octets& content);
  Body& align() { return zeros((4 - bytes.size() % 4) % 4); }
  Octets bytes;
  bool little;

 private:
  Body& put(std::uint64_t value, unsigned n);
};

class Grammar {
 public:
  struct Ports {
    std::uint16_t group = 7400;
    std::uint16_t discovery = 7410;
    std::uint16_t samples = 7411;
    std::uint16_t peers = 0;  ///< where peers claim to receive
  };
  /// `own` are the readers and writers of the participant with the prefix `mine`. `certificate` is not empty
  /// with DDS Security.
  Grammar(Ports ports, const Prefix& mine, std::vector<Endpoint> readers, std::vector<Endpoint> writers,
          Octets certificate);

  /// Returns the packets after which the participant knows the peer anew, with a writer for each of its
  /// readers and a reader for each of its writers.
  std::vector<Packet> introduction(const Prefix& peer);
  /// Returns a packet of one of the peers.
  Packet packet(Dice& dice);

  /// A sample of a writer of a peer, numbered from 1.
  Packet sample(const Prefix& peer, const std::string& topic, std::int64_t number, const Octets& content);

  static constexpr std::size_t kPeers = 3;
  static Prefix peer(std::size_t i);

 private:
  struct Part {
    std::uint8_t kind = 0;
    std::uint8_t flags = 0;
    Octets body;
  };
  using Parts = std::vector<Part>;
  using Make = Parts (Grammar::*)();

  bool breaks(Rule rule);
  std::uint64_t edge();
  std::int64_t number_near(std::int64_t next);
  std::int64_t low();
  std::int64_t high();
  void cut(Body& body, std::size_t most);
  std::size_t any_reader();
  Octets random(std::size_t n);
  std::string words();
  bool little() { return dice_->once_in(4) ? false : true; }
  Part part(std::uint8_t kind, unsigned flags, Body body) const;

  void put_text(Body& body, Rule too_long, Rule without_end = Rule::none);
  void put_set(Body& body, std::uint32_t least);
  void put_token(Body& body, bool in_proof);
  std::uint32_t many(std::uint32_t n, Rule rule);
  Octets value_of(std::uint32_t parameter, bool is_little);
  void put_parameter(Body& body, std::uint32_t parameter);
  void put_end(Body& body);
  Octets parameters(bool is_little);
  Octets announcement(bool is_little);
  Octets endpoint(bool is_little, const Endpoint& of, bool writes, const Prefix& peer);
  std::uint32_t discovery_parameter();
  void put_ids(Body& body, bool to_reader);
  Octets head(bool is_little, std::uint32_t writer, bool fragment, std::size_t skipped);

  Parts data();
  Parts discovery();
  Parts proof();
  Parts fragment();
  Parts heartbeat();
  Parts acknack();
  Parts gap();
  Parts nack_frag();
  Parts heartbeat_frag();
  Parts info();
  Parts reply();
  Parts other();
  Parts protect(std::uint8_t prefix_kind);
  Parts protected_parts();
  Parts protected_whole();
  Parts announcing();

  [[nodiscard]] Make maker_of(Rule rule) const;
  Octets message(const Parts& parts);
  void damage(Octets& bytes);

  Ports ports_;
  Prefix mine_;
  std::vector<Endpoint> readers_;
  std::vector<Endpoint> writers_;
  Octets certificate_;

  Dice* dice_ = nullptr;
  Rule target_ = Rule::none;
  bool broken_ = false;
  bool advances_ = false;  // true if the packet will arrive unchanged
  std::size_t favourite_peer_ = 0;
  std::size_t favourite_ = 0;
  Prefix from_{};
  std::uint16_t port_ = 0;
  std::uint32_t count_ = 0;
  std::map<std::pair<Prefix, std::uint32_t>, std::int64_t> next_;  // the number that a reader expects next
  std::map<std::pair<Prefix, std::uint32_t>, std::int64_t> of_fragment_;  // the number of the last one
};

}  // namespace fuzz
