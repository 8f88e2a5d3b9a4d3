// Sends the key of each disposed sample as bytes. Fast DDS 2.9.1 sends only the MD5 hash of the key. A reader
// of another DDS implementation cannot find the sample by this hash: Cyclone DDS drops the message, so its
// readers never see the disposal. Only the source files of this room include this header.
#pragma once

#include <string_view>
#include <vector>

namespace takt::dds {

/// Encodes a key, which is the path of a sample. While this object exists, each disposal and unregistration
/// that this thread makes sends the encoded key.
class SentKey {
 public:
  explicit SentKey(std::string_view path);
  ~SentKey();
  SentKey(const SentKey&) = delete;
  SentKey& operator=(const SentKey&) = delete;

 private:
  std::vector<char> bytes_;
};

}  // namespace takt::dds
