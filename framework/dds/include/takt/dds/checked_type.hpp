// A generated type of Fast DDS, without what would end a process or mix up its keys. Not for other rooms.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>

#include <takt/dds/inside.hpp>

namespace takt::dds {

/// What a type could not make a sample of, for all its readers in this process.
struct Undecoded {
  std::atomic<std::uint64_t> count{0};
};

template <class Generated>
class CheckedType final : public Generated, public Undecoded {
 public:
  // The generated function lets most exceptions of the decoder out, into a thread of Fast DDS.
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    try {
      if (Generated::deserialize(payload, data)) return true;
    } catch (...) {  // whatever the bytes made it throw
    }
    count.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  // It computes keys in one buffer for all writers and readers of a participant, and leaves in it what an
  // earlier key wrote.
  bool getKey(void* data, rtps::InstanceHandle_t* handle, bool force_md5 = false) override {
    if (!this->m_isGetKeyDefined) return false;
    const std::lock_guard lock{mutex_};
    std::memset(this->m_keyBuffer, 0,
                std::max<std::size_t>(16, Generated::type::getKeyMaxCdrSerializedSize()));
    return Generated::getKey(data, handle, force_md5);
  }

 private:
  std::mutex mutex_;
};

/// The one that is used for a topic in this process, which may be older than the one that was offered.
inline Undecoded& undecoded(fast::DomainParticipant& participant, const fast::Topic& topic) {
  return *dynamic_cast<Undecoded*>(participant.find_type(topic.get_type_name()).get());
}

}  // namespace takt::dds
