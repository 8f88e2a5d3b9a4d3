// Wraps a generated type of Fast DDS, so that forged bytes cannot crash the process or mix up keys. Only the
// source files of this room include this header.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>

#include "../inside.hpp"

namespace takt::dds {

/// Counts the samples of one type that could not be decoded, for all readers of this type in this process.
struct Undecoded {
  std::atomic<std::uint64_t> count{0};
};

template <class Generated>
class CheckedType final : public Generated, public Undecoded {
 public:
#if TAKT_FASTDDS == 2
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override { return decode(payload, data); }
  // Locks and clears the buffer for keys first, because the generated function uses one buffer for all
  // threads and keys, and does not clear it.
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5 = false) override {
    if (!this->m_isGetKeyDefined) return false;
    const std::lock_guard lock{mutex_};
    std::memset(this->m_keyBuffer, 0,
                std::max<std::size_t>(16, Generated::type::getKeyMaxCdrSerializedSize()));
    return Generated::getKey(data, handle, force_md5);
  }
#else
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override { return decode(payload, data); }
  // Fast DDS would store a sample without a key, and then an assertion would end the process. So all samples
  // that cannot be decoded get one key, which no valid sample has. They are dropped when they are taken.
  bool compute_key(rtps::SerializedPayload_t& payload, rtps::InstanceHandle_t& handle,
                   bool force_md5 = false) override {
    if (!this->is_compute_key_provided) return false;
    if (!Generated::compute_key(payload, handle, force_md5))
      std::fill_n(&handle.value[0], 16, std::uint8_t{0xff});
    return true;
  }
  bool compute_key(const void* data, rtps::InstanceHandle_t& handle, bool force_md5 = false) override {
    const std::lock_guard lock{mutex_};
    return Generated::compute_key(data, handle, force_md5);
  }
#endif

 private:
  // Decodes a sample, and catches the exceptions of the generated decoder. Fast DDS does not catch most of
  // these exceptions, so they would end the process.
  template <class Payload>
  bool decode(Payload&& payload, void* data) {
    try {
      if (Generated::deserialize(payload, data)) return true;
    } catch (...) {  // the bytes are not a valid sample; counted below
    }
    count.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  std::mutex mutex_;
};

/// Returns the counter of the type that this process has registered for a topic. An earlier user of the topic
/// may have registered the type.
inline Undecoded& undecoded(fast::DomainParticipant& participant, const fast::Topic& topic) {
  return *dynamic_cast<Undecoded*>(participant.find_type(topic.get_type_name()).get());
}

}  // namespace takt::dds
