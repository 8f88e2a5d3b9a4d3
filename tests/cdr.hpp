// Encodes and decodes samples of the classes of fastddsgen, with Fast CDR 1 or 2.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

namespace takt::cdr {

namespace fast = eprosima::fastcdr;

/// Returns the sample in CDR with its encapsulation header. It may have up to 64 KiB. The padding, which Fast
/// CDR does not write, is zero.
template <class T>
std::vector<std::byte> encoded(const T& value, fast::Cdr::Endianness endianness) {
  std::vector<char> bytes(65536);
  fast::FastBuffer buffer{bytes.data(), bytes.size()};
#if __has_include(<fastcdr/CdrSizeCalculator.hpp>)  // Fast CDR 2
  fast::Cdr cdr{buffer, endianness, fast::CdrVersion::XCDRv1};
  cdr.set_encoding_flag(fast::EncodingAlgorithmFlag::PLAIN_CDR);
  cdr.serialize_encapsulation();
  cdr << value;
  const std::size_t size = cdr.get_serialized_data_length();
#else
  fast::Cdr cdr{buffer, endianness, fast::Cdr::DDS_CDR};
  cdr.serialize_encapsulation();
  value.serialize(cdr);
  const std::size_t size = cdr.getSerializedDataLength();
#endif
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + size};
}

/// Decodes a sample in CDR with its encapsulation header. Throws an exception if the bytes are not valid.
template <class T>
void decode(std::string_view bytes, T& value) {
  std::vector<char> copy{bytes.begin(), bytes.end()};
  fast::FastBuffer buffer{copy.data(), copy.size()};
#if __has_include(<fastcdr/CdrSizeCalculator.hpp>)
  fast::Cdr cdr{buffer};
  cdr.read_encapsulation();
  cdr >> value;
#else
  fast::Cdr cdr{buffer, fast::Cdr::DEFAULT_ENDIAN, fast::Cdr::DDS_CDR};
  cdr.read_encapsulation();
  value.deserialize(cdr);
#endif
}

}  // namespace takt::cdr
