// Reads and writes samples as raw bytes, for types that were not compiled into this process. Only the source
// files of this room include this header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <takt/dds/gateway.hpp>
#include <takt/model/type.hpp>
#include "inside.hpp"

namespace takt::dds {

/// The bytes of one sample, in CDR with its encapsulation header.
struct Bytes {
  const std::byte* data = nullptr;
  std::size_t size = 0;
};

/// The object that a raw reader passes to Fast DDS as the destination of a sample:
/// `take_next_sample(static_cast<Taker*>(me), &info)`.
class Taker {
 public:
  virtual ~Taker() = default;
  /// Takes the bytes of one sample. The bytes are in the history of DDS and are valid only during the call.
  virtual void take(const Bytes& bytes) = 0;
};

/// A bounded type for samples as raw bytes. `max_size` is the size of the largest sample, including the
/// encapsulation header.
class RawType : public EncodedType {
 public:
  RawType(const std::string& name, std::size_t max_size, bool keyed = false)
      : EncodedType(name, static_cast<std::uint32_t>((max_size + 3) / 4 * 4), keyed) {}

 private:
  bool encode(const void* data, rtps::SerializedPayload_t& to) final;
  void decode(const rtps::SerializedPayload_t& from, void* data) final;
  std::uint32_t size_of(const void* data) final {
    return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size);
  }
  rtps::InstanceHandle_t key_of(const void* data) final { return key_of(*static_cast<const Bytes*>(data)); }
  /// Only a test has a type with a key.
  virtual rtps::InstanceHandle_t key_of(const Bytes&) { return {}; }
};

/// The state and counters of one flow. Any thread may use this object.
class Health {
 public:
  void matched(std::int32_t count) { matched_ = static_cast<std::uint32_t>(count); }
  void incompatible(fast::QosPolicyId_t policy);
  void moved() { samples_.fetch_add(1, std::memory_order_relaxed); }
  void lost(std::uint64_t count) { lost_.fetch_add(count, std::memory_order_relaxed); }
  void refused() { refused_.fetch_add(1, std::memory_order_relaxed); }
  void failed() { failures_.fetch_add(1, std::memory_order_relaxed); }
  [[nodiscard]] wire::FlowHealth read() const;

 private:
  std::atomic<std::uint32_t> matched_{0};
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<std::uint64_t> lost_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<std::uint64_t> failures_{0};
  mutable std::mutex mutex_;
  std::string incompatible_;
};

/// Writes samples of one topic. A test replaces it by a writer that is slow.
class SampleWriter {
 public:
  virtual ~SampleWriter() = default;
  /// Writes a sample with the source time `time_ns`, in ns since 1970. `number` is the number of the sample
  /// among all that were meant for this topic, from 1; 0: unknown. If DDS rejects the sample, returns false
  /// and counts a failure.
  virtual bool write(const Bytes& bytes, std::int64_t time_ns, std::uint64_t number) = 0;
  /// Never waits for a write.
  [[nodiscard]] virtual wire::FlowHealth health() const = 0;
};

/// Writes samples of one topic to DDS.
class RawWriter final : public SampleWriter, fast::DataWriterListener {
 public:
  static Result<std::unique_ptr<RawWriter>> create(std::shared_ptr<Participant> participant,
                                                   const Flow& flow);
  ~RawWriter() override;

  bool write(const Bytes& bytes, std::int64_t time_ns, std::uint64_t number) override;
  [[nodiscard]] wire::FlowHealth health() const override { return health_.read(); }

 private:
  RawWriter(std::shared_ptr<Participant> participant, Flow flow)
      : participant_(std::move(participant)), flow_(std::move(flow)) {}
  Result<void> make();
  void on_publication_matched(fast::DataWriter*, const fast::PublicationMatchedStatus& status) override;
  void on_offered_incompatible_qos(fast::DataWriter*,
                                   const fast::OfferedIncompatibleQosStatus& status) override;

  std::shared_ptr<Participant> participant_;
  Flow flow_;
  fast::Topic* topic_ = nullptr;
  fast::DataWriter* writer_ = nullptr;
  Health health_;
};

/// Counts the samples that are missing between the samples of each writer.
class Gaps {
 public:
  /// Returns how many samples are missing between the last sample of the writer and this one.
  std::uint64_t before(const rtps::SampleIdentity& sample);

 private:
  std::map<std::uint64_t, std::int64_t> last_;  // last sample number, by writer
};

/// Reads samples of one topic and passes the valid ones to a receiver.
class RawReader final : fast::DataReaderListener, Taker {
 public:
  /// Receives the samples. Threads of Fast DDS call a Receiver, but never two at the same time.
  struct Receiver {
    virtual ~Receiver() = default;
    /// Called before receive(), if `count` samples before this one are missing: on the way, or because the
    /// writer's device did not send them.
    virtual void lost(std::uint64_t count) { static_cast<void>(count); }
    /// Called first for each valid sample, with the bytes of the sample. The bytes are valid only during the
    /// call.
    virtual void receive(const Bytes& bytes) = 0;
    /// Called after receive(), with the source time of this sample, in ns since 1970.
    virtual void received(std::int64_t time_ns) = 0;
    /// Called after receive() and received() were called for all samples that have arrived so far.
    virtual void done() {}
  };

  static Result<std::unique_ptr<RawReader>> create(std::shared_ptr<Participant> participant, const Flow& flow,
                                                   Receiver& receiver);
  /// Waits until no call of the receiver is running. When the destructor has returned, the receiver is not
  /// called any more.
  ~RawReader() override;
  [[nodiscard]] wire::FlowHealth health() const { return health_.read(); }

 private:
  RawReader(std::shared_ptr<Participant> participant, Flow flow, Receiver& receiver)
      : participant_(std::move(participant)), flow_(std::move(flow)), receiver_(receiver) {}
  Result<void> make();
  void take(const Bytes& bytes) override;
  void on_data_available(fast::DataReader* from) override;
  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override;
  void on_requested_incompatible_qos(fast::DataReader*,
                                     const fast::RequestedIncompatibleQosStatus& status) override;

  std::shared_ptr<Participant> participant_;
  Flow flow_;
  Receiver& receiver_;
  fast::Topic* topic_ = nullptr;
  fast::DataReader* reader_ = nullptr;
  std::mutex calling_;
  bool is_sample_ = false;  // true if the bytes in the last call of take() were a valid sample
  Gaps sent_;               // by the sequence numbers of DDS
  Gaps written_;            // by the numbers that the writers gave to their samples
  Health health_;
};

}  // namespace takt::dds
