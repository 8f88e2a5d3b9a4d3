// Sends the key of each disposed sample as bytes. Fast DDS 2.9.1 sends only the MD5 hash of the key. A reader
// of another DDS implementation cannot find the sample by this hash: Cyclone DDS drops the message, so its
// readers never see the disposal. Only the source files of this room include this header.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <fastcdr/Cdr.h>

#include "../inside.hpp"

namespace takt::dds {

/// Encodes the key of `sample`. While this object exists, each disposal and unregistration that this thread
/// makes sends the encoded key.
class SentKey {
 public:
  template <class T>
  explicit SentKey(const T& sample) : bytes_(kLongest) {
    eprosima::fastcdr::FastBuffer buffer{bytes_.data(), bytes_.size()};
    eprosima::fastcdr::Cdr cdr{buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN,
                               eprosima::fastcdr::Cdr::DDS_CDR};
    cdr.serialize_encapsulation();
    sample.serializeKey(cdr);
    // The bytes after the key are zero, and readers ignore them.
    bytes_.resize(std::max(kShortest, cdr.getSerializedDataLength()));
    install();
  }
  ~SentKey();
  SentKey(const SentKey&) = delete;
  SentKey& operator=(const SentKey&) = delete;

 private:
  // A Fast DDS reader would interpret a key of up to 16 bytes as the hash of a key, and dispose of another
  // sample.
  static constexpr std::size_t kShortest = 20;
  static constexpr std::size_t kLongest = 512;  // a key is a string of at most 255 characters
  void install() noexcept;

  std::vector<char> bytes_;
};

}  // namespace takt::dds
