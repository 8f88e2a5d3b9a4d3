// A data type for the tests. The tests build its samples byte by byte, without generated code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <takt/dds/gateway.hpp>
#include <takt/model/type.hpp>

namespace takt::dds_test {

inline constexpr std::size_t kMostData = 65536;

/// Returns this type:
/// struct Sample { unsigned long long number; long long value; sequence<octet, 65536> data; };
inline model::Type sample_type() {
  return {.name = "test::Sample",
          .fields = {{.name = "number", .scalar = model::Scalar::uint64},
                     {.name = "value", .scalar = model::Scalar::int64},
                     {.name = "data", .scalar = model::Scalar::octet, .sequence = kMostData}}};
}

inline dds::Flow flow(const std::string& topic, dds::Quality quality = {}) {
  return {.topic = topic, .type = sample_type(), .quality = quality};
}

/// Encodes a sample with `data` bytes of data in XCDR1, little endian.
inline std::vector<std::byte> bytes_of(std::uint64_t number, std::int64_t value = 0, std::uint32_t data = 0) {
  std::vector<std::byte> bytes(24);
  bytes[1] = std::byte{1};
  std::memcpy(bytes.data() + 4, &number, 8);
  std::memcpy(bytes.data() + 12, &value, 8);
  std::memcpy(bytes.data() + 20, &data, 4);
  for (std::uint32_t i = 0; i < data; ++i) bytes.push_back(static_cast<std::byte>(number + i));
  return bytes;
}

inline std::uint64_t number_in(const std::byte* bytes) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes + 4, 8);
  return number;
}

inline std::int64_t value_in(const std::byte* bytes) {
  std::int64_t value = 0;
  std::memcpy(&value, bytes + 12, 8);
  return value;
}

/// Returns true if the sample is complete and its data is as bytes_of() made it.
inline bool is_whole(const std::byte* bytes, std::size_t size) {
  std::uint32_t data = 0;
  if (size < 24) return false;
  std::memcpy(&data, bytes + 20, 4);
  if (size < 24 + std::size_t{data}) return false;
  for (std::uint32_t i = 0; i < data; ++i) {
    if (bytes[24 + i] != static_cast<std::byte>(number_in(bytes) + i)) return false;
  }
  return true;
}

}  // namespace takt::dds_test
