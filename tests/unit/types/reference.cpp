// Builds samples with the classes of fastddsgen. For this file, CMakeLists.txt renames the namespaces of
// these classes and of values.hpp, because the test program also contains Takt's classes of the same names.
#include "reference.hpp"

#include <cstdint>
#include <stdexcept>
#include <string>

#include <cdr.hpp>
#include "values.hpp"  // here, includes the classes of fastddsgen

namespace takt::types_reference {
namespace {

template <class T>
Bytes serialized(const T& value, Endianness endianness) {
  using Cdr = eprosima::fastcdr::Cdr;
  return cdr::encoded(value, endianness == Endianness::little ? Cdr::LITTLE_ENDIANNESS : Cdr::BIG_ENDIANNESS);
}

/// One sample, encoded in each byte order.
struct Sample {
  Bytes little;
  Bytes big;
};
template <class T>
Sample sample(const T& value) {
  return {serialized(value, Endianness::little), serialized(value, Endianness::big)};
}

}  // namespace

Bytes sample_of_fast_dds(std::string_view value) {
  constexpr auto kLittle = Endianness::little;
  if (value == "part") return serialized(types_test::part(3), kLittle);
  if (value == "scalars") return serialized(types_test::scalars(), kLittle);
  if (value == "whole 0") return serialized(types_test::whole(0), kLittle);
  if (value == "whole 0.5") return serialized(types_test::whole(0.5), kLittle);
  if (value == "whole 1") return serialized(types_test::whole(1), kLittle);
  if (value == "tail") return serialized(types_test::tail(), kLittle);
  if (value == "new") return serialized(everything::Whole{}, kLittle);
  throw std::invalid_argument("no value " + std::string{value});
}

Bytes sample_of_fast_dds(const Bytes& little, Endianness endianness) {
  std::vector<Sample> samples{sample(parts::Part{}),         sample(everything::Scalars{}),
                              sample(everything::Whole{}),   sample(everything::Tail{}),
                              sample(types_test::scalars()), sample(types_test::odd_numbers()),
                              sample(types_test::whole(0)),  sample(types_test::whole(0.5)),
                              sample(types_test::whole(1)),  sample(types_test::tail())};
  for (std::uint8_t kind = 0; kind < 8; ++kind) samples.push_back(sample(types_test::part(kind)));
  for (const Sample& each : samples) {
    if (each.little == little) return endianness == Endianness::little ? each.little : each.big;
  }
  throw std::invalid_argument("Fast DDS sends other bytes, or the value is not one of values.hpp");
}

}  // namespace takt::types_reference
