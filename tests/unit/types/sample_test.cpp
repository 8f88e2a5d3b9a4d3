// Compares a type that was parsed from its description with the code that was generated from the same IDL.
// Both must accept the same samples, and must encode a sample to the same bytes.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nested.hpp>
#include <takt/model/type.hpp>

#include "heap_watch.hpp"
#include "reference.hpp"
#include "values.hpp"

namespace takt::model::sample_test {
namespace {

using types_reference::by_fast_cdr;
using types_reference::Bytes;
using types_reference::encoded;
using types_reference::Endianness;
using types_test::part;
using types_test::scalars;
using types_test::tail;
using types_test::whole;

template <class T>
Type type_of() {
  return parse_type(PortType<T>::info.description).value();
}

template <class T>
void expect_parsed_type_matches_code() {
  const auto type = parse_type(PortType<T>::info.description);
  ASSERT_TRUE(type.ok()) << to_text(type.problems());
  EXPECT_EQ(type->name, PortType<T>::info.name);
  EXPECT_EQ(to_text(*type), PortType<T>::info.description);
  EXPECT_EQ(max_size(*type), PortType<T>::info.max_size);
}

TEST(ParsedType, MatchesTheGeneratedCode) {
  expect_parsed_type_matches_code<parts::Part>();
  expect_parsed_type_matches_code<everything::deep::Bottom>();
  expect_parsed_type_matches_code<everything::Scalars>();
  expect_parsed_type_matches_code<everything::Whole>();
  expect_parsed_type_matches_code<everything::Tail>();
  expect_parsed_type_matches_code<nested::Lists>();
}

TEST(ParsedType, ReadsAndWritesTheSampleThatTheGeneratedCodeEncodes) {
  nested::Lists value;
  value.labels()[1] = {"a", "", "cde"};
  value.modes()[1][0] = {nested::ON};
  value.groups() = {{"x", "yz"}, {"", "uvw"}};
  value.states() = {{{nested::OFF, nested::ON}, {nested::ON, nested::ON}}};
  value.last(7);
  const Type type = type_of<nested::Lists>();
  const Bytes bytes = encoded(value);
  ASSERT_TRUE(is_sample(type, bytes.data(), bytes.size()));
  const std::string json = sample_json(type, bytes.data(), bytes.size());
  EXPECT_EQ(json,
            R"({"labels": [[], ["a", "", "cde"]], "modes": [[[], []], [["ON"], []]], )"
            R"("groups": [["x", "yz"], ["", "uvw"]], "states": [["OFF", "ON"], ["ON", "ON"]], "last": 7})");
  const auto again = sample_bytes(type, json);
  ASSERT_TRUE(again.ok()) << to_text(again.problems());
  EXPECT_EQ(*again, bytes);
  nested::Lists other;
  ASSERT_TRUE(PortType<nested::Lists>::decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), other));
  EXPECT_EQ(other, value);
}

/// Expects that the samples that Fast DDS encodes for this value are valid, and that printing them as JSON
/// and reading the JSON does not change them.
template <class T>
void expect_through_json(const T& value) {
  const Type type = type_of<T>();
  const Bytes little = by_fast_cdr(value, Endianness::little);
  const Bytes big = by_fast_cdr(value, Endianness::big);
  ASSERT_TRUE(is_sample(type, little.data(), little.size()));
  ASSERT_TRUE(is_sample(type, big.data(), big.size()));
  const std::string json = sample_json(type, little.data(), little.size());
  EXPECT_EQ(sample_json(type, big.data(), big.size()), json);
  EXPECT_EQ(json.find('\n'), std::string::npos);
  const auto again = sample_bytes(type, json);
  ASSERT_TRUE(again.ok()) << to_text(again.problems());
  EXPECT_EQ(*again, little);
}

TEST(Sample, SurvivesARoundTripThroughJson) {
  expect_through_json(part(5));
  expect_through_json(scalars());
  for (const double fill : {0.0, 0.5, 1.0}) expect_through_json(whole(fill));
  expect_through_json(everything::Whole{});
  expect_through_json(tail());
}

TEST(Sample, IsPrintedWithTheNamesOfItsFields) {
  const Bytes bytes = by_fast_cdr(scalars(), Endianness::big);
  EXPECT_EQ(
      sample_json(type_of<everything::Scalars>(), bytes.data(), bytes.size()),
      R"({"flag": true, "byte": 200, "letter": "L", "small": -2, "usmall": 65000, "whole": -70000, )"
      R"("uwhole": 4000000000, "big": -5000000000, "ubig": 18000000000000000000, "single": 1.5, "real": -2.25, )"
      R"("i8": -8, "u8": 8, "i16": -16, "u16": 16, "i32": -32, "u32": 32, "i64": -64, "u64": 64, )"
      R"("name": "12345678", "mode": "HOLD"})");
}

TEST(Sample, HasTheDefaultValueInEachFieldThatItsJsonOmits) {
  const auto bytes = sample_bytes(type_of<everything::Whole>(), "{}");
  ASSERT_TRUE(bytes.ok());
  EXPECT_EQ(*bytes, by_fast_cdr(everything::Whole{}, Endianness::little));
}

/// Makes random samples, valid and invalid ones, from copies of valid samples with up to three changes each.
class Mutation {
 public:
  explicit Mutation(std::vector<Bytes> seeds) : seeds_(std::move(seeds)) {}

  Bytes next() {
    Bytes bytes = seeds_[number(seeds_.size())];
    for (std::size_t changes = number(4); changes > 0 && !bytes.empty(); --changes) change(bytes);
    return bytes;
  }

 private:
  std::size_t number(std::size_t below) {
    return std::uniform_int_distribution<std::size_t>{0, below - 1}(random_);
  }

  void change(Bytes& bytes) {
    const std::size_t at = number(bytes.size());
    switch (number(7)) {
      case 0:
        bytes[at] ^= std::byte{1} << number(8);
        break;
      case 1:
        bytes[at] = static_cast<std::byte>(number(256));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.resize(bytes.size() + number(9), static_cast<std::byte>(number(256)));
        break;
      case 4:
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      case 5:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), 4, std::byte{0});
        break;
      default:  // a small number, which may be a length, a boolean or an enumerator
        bytes[at] = static_cast<std::byte>(number(6));
    }
  }

  std::mt19937_64 random_{20250101};
  std::vector<Bytes> seeds_;
};

template <class T>
void expect_agreement(const std::vector<T>& values, std::size_t rounds) {
  std::vector<Bytes> seeds;
  for (const T& value : values) {
    seeds.push_back(by_fast_cdr(value, Endianness::little));
    seeds.push_back(by_fast_cdr(value, Endianness::big));
  }
  const Type type = type_of<T>();
  Mutation mutation{std::move(seeds)};
  std::size_t samples = 0;
  T value;
  PortType<T>::reserve(value);
  std::uint64_t allocations = 0;
  for (std::size_t i = 0; i < rounds; ++i) {
    const Bytes bytes = mutation.next();
    bool is = false;
    bool decoded = false;
    allocations += types_test::allocations_of([&] {
      is = is_sample(type, bytes.data(), bytes.size());
      decoded = PortType<T>::decode(bytes.data(), static_cast<std::uint32_t>(bytes.size()), value);
    });
    ASSERT_EQ(is, decoded) << "round " << i;
    if (!is) continue;
    ++samples;
    if (samples % 16 == 0) {
      // The test prints and encodes every 16th valid sample.
      ASSERT_FALSE(sample_json(type, bytes.data(), bytes.size()).empty());
      Bytes again(PortType<T>::info.max_size);
      ASSERT_GT(PortType<T>::encode(value, again.data(), PortType<T>::info.max_size), 0U);
    }
  }
  if (types_test::kHeapIsWatched) {
    EXPECT_EQ(allocations, 0U);
  }
  // The test must have tried enough valid samples and enough invalid samples.
  EXPECT_GT(samples, rounds / 10);
  EXPECT_LT(samples, rounds * 9 / 10);
}

TEST(Sample, IsValidExactlyIfTheGeneratedCodeDecodesIt) {
  expect_agreement<everything::Scalars>({scalars(), {}}, 40'000);
  expect_agreement<everything::Whole>({whole(0), whole(0.5), whole(1), {}}, 40'000);
  expect_agreement<everything::Tail>({tail(), {}}, 20'000);
}

}  // namespace
}  // namespace takt::model::sample_test
