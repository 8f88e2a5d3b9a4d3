// Encodes the types of everything.idl with the classes that fastddsgen generates and with Fast CDR. The tests
// compare these samples with those of Takt's code.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include <takt/component/port_type.hpp>

namespace takt::types_reference {

using Bytes = std::vector<std::byte>;
enum class Endianness { little, big };

/// Returns the sample that Fast DDS would send for a value that values.hpp makes: "part", "scalars", "whole
/// 0", "whole 0.5", "whole 1" or "tail". "new" is a new everything::Whole.
Bytes sample_of_fast_dds(std::string_view value);

/// Returns the sample that Fast DDS would send in this byte order for a value. `little` is the value's sample
/// in little-endian order. The value must be a new object, or one that values.hpp makes.
Bytes sample_of_fast_dds(const Bytes& little, Endianness endianness);

template <class T>
Bytes encoded(const T& value) {
  Bytes bytes(PortType<T>::info.max_size, std::byte{0xEE});  // encode() must set the padding to zero
  bytes.resize(PortType<T>::encode(value, bytes.data(), PortType<T>::info.max_size));
  return bytes;
}

/// Returns the bytes that Fast DDS would send for this value. The value must be a new object, or one that
/// values.hpp makes.
template <class T>
Bytes by_fast_cdr(const T& value, Endianness endianness) {
  return sample_of_fast_dds(encoded(value), endianness);
}

}  // namespace takt::types_reference
