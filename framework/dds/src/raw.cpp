#include "raw.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace takt::dds {

namespace {

constexpr std::size_t kWriters = 64;  // the number of writers whose sequence numbers a reader tracks
// The largest gap that a reader believes, so that a wrong number cannot make a sum of gaps overflow.
constexpr std::uint64_t kMostMissing = std::uint64_t{1} << 32;
constexpr std::int32_t kReliableReaderDepth = 32;
// The largest number of bytes that Fast DDS preallocates for the samples of one flow.
constexpr std::size_t kPreallocated = 4 * 1024 * 1024;
constexpr Nanoseconds kFlowHeartbeat = std::chrono::milliseconds{10};
constexpr Nanoseconds kFlowAnswer = std::chrono::milliseconds{1};

template <class Qos>
void set_flow_quality(Qos& qos, const Quality& quality, std::int32_t depth, std::size_t sample) {
  qos.reliability().kind =
      quality.reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = quality.kept ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  if (quality.deadline) qos.deadline().period = duration(*quality.deadline);
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples = depth;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().allocated_samples =
      std::clamp(static_cast<std::int32_t>(std::min<std::size_t>(kPreallocated / sample, 65536)), 1, depth);
  qos.data_sharing().off();
}

Result<fast::Topic*> topic_of(Participant& participant, const Flow& flow) {
  return own(participant)
      .topic(flow.topic, fast::TypeSupport{new RawType{flow.type.name, model::max_size(flow.type)}});
}

std::int32_t depth_of(const Quality& quality) {
  return static_cast<std::int32_t>(std::clamp<std::uint32_t>(quality.depth, 1, 65536));
}

}  // namespace

bool RawType::encode(const void* data, rtps::SerializedPayload_t& to) {
  const Bytes& bytes = *static_cast<const Bytes*>(data);
  if (bytes.size < 4 || bytes.size > to.max_size) return false;
  std::memcpy(to.data, bytes.data, bytes.size);
  to.length = static_cast<std::uint32_t>(bytes.size);
  to.encapsulation = bytes.data[1] == std::byte{0} ? CDR_BE : CDR_LE;
  return true;
}

void RawType::decode(const rtps::SerializedPayload_t& from, void* data) {
  static_cast<Taker*>(data)->take({reinterpret_cast<const std::byte*>(from.data), from.length});
}

void Health::incompatible(fast::QosPolicyId_t policy) {
  const std::lock_guard lock{mutex_};
  incompatible_ = policy_name(policy);
}

wire::FlowHealth Health::read() const {
  constexpr auto relaxed = std::memory_order_relaxed;
  const std::lock_guard lock{mutex_};
  return {.matched = matched_.load(relaxed),
          .samples = samples_.load(relaxed),
          .lost = lost_.load(relaxed),
          .refused = refused_.load(relaxed),
          .failures = failures_.load(relaxed),
          .incompatible = incompatible_};
}

// ---- Writer

Result<std::unique_ptr<RawWriter>> RawWriter::create(std::shared_ptr<Participant> participant,
                                                     const Flow& flow) {
  std::unique_ptr<RawWriter> writer{new RawWriter{std::move(participant), flow}};
  auto topic = topic_of(*writer->participant_, flow);
  if (!topic) return topic.problems();
  writer->topic_ = *topic;
  if (auto made = writer->make(); !made) return made.problems();
  return writer;
}

RawWriter::~RawWriter() {
  own(*participant_).end(writer_);
  if (topic_ != nullptr) own(*participant_).release(topic_);
}

Result<void> RawWriter::make() {
  fast::DataWriterQos qos;
  set_flow_quality(qos, flow_.quality, depth_of(flow_.quality), model::max_size(flow_.type));
  // The reader has no lifespan in DDS, because Fast DDS would compare the source time with the reader's
  // clock.
  if (flow_.quality.lifespan) qos.lifespan().duration = duration(*flow_.quality.lifespan);
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_MEMORY_MODE;
  qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
  set_times(qos, kFlowHeartbeat);
  qos.writer_resource_limits().reader_filters_allocation.maximum = 0;
  fast::StatusMask mask = fast::StatusMask::publication_matched();
  mask << fast::StatusMask::offered_incompatible_qos();
  writer_ = own(*participant_).make_writer(topic_, qos, this, mask);
  if (writer_ == nullptr)
    return fail("DDS could not create a writer for topic '" + flow_.topic + "'",
                "see the message that DDS printed");
  return {};
}

bool RawWriter::write(const Bytes& bytes, std::int64_t time_ns, std::uint64_t number) {
  // Fast DDS never returns from write() if the nanoseconds of the time are negative (CVE-2025-63829).
  rtps::WriteParams parameters;
  parameters.source_timestamp().from_ns(std::max<std::int64_t>(time_ns, 0));
  if (number != 0) {
    parameters.related_sample_identity().writer_guid(writer_->guid());
    parameters.related_sample_identity().sequence_number(rtps::SequenceNumber_t{number});
  }
  const bool taken = write_sample(*writer_, &bytes, parameters);
  taken ? health_.moved() : health_.failed();
  return taken;
}

void RawWriter::on_publication_matched(fast::DataWriter*, const fast::PublicationMatchedStatus& status) {
  health_.matched(status.current_count);
}

void RawWriter::on_offered_incompatible_qos(fast::DataWriter*,
                                            const fast::OfferedIncompatibleQosStatus& status) {
  health_.incompatible(status.last_policy_id);
}

// ---- Reader

std::uint64_t Gaps::before(const rtps::SampleIdentity& sample) {
  const std::uint64_t writer = number_of(sample.writer_guid());
  const auto number = static_cast<std::int64_t>(sample.sequence_number().to64long());
  if (last_.size() >= kWriters && last_.find(writer) == last_.end()) last_.clear();
  const auto [last, first] = last_.try_emplace(writer, number);
  const std::int64_t before = std::exchange(last->second, std::max(last->second, number));
  if (first || number <= before) return 0;
  return std::min(static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(before) - 1, kMostMissing);
}

Result<std::unique_ptr<RawReader>> RawReader::create(std::shared_ptr<Participant> participant,
                                                     const Flow& flow, Receiver& receiver) {
  std::unique_ptr<RawReader> reader{new RawReader{std::move(participant), flow, receiver}};
  auto topic = topic_of(*reader->participant_, flow);
  if (!topic) return topic.problems();
  reader->topic_ = *topic;
  if (auto made = reader->make(); !made) return made.problems();
  return reader;
}

RawReader::~RawReader() {
  own(*participant_).end(reader_);
  if (topic_ != nullptr) own(*participant_).release(topic_);
}

Result<void> RawReader::make() {
  fast::DataReaderQos qos;
  // If a sample was lost, the reader must keep later samples until the writer has sent the lost sample again.
  // So a reliable reader needs a deeper history.
  const std::int32_t depth = flow_.quality.reliable ? std::max(depth_of(flow_.quality), kReliableReaderDepth)
                                                    : depth_of(flow_.quality);
  set_flow_quality(qos, flow_.quality, depth, model::max_size(flow_.type));
  // Let the buffers grow. With fixed buffers, Fast DDS would try again and again to deliver a sample that is
  // too long, without counting it as rejected.
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  set_times(qos, kFlowAnswer);
  fast::StatusMask mask = fast::StatusMask::data_available();
  mask << fast::StatusMask::subscription_matched() << fast::StatusMask::requested_incompatible_qos();
  reader_ = own(*participant_).make_reader(topic_, qos, this, mask, Receives::alone);
  if (reader_ == nullptr)
    return fail("DDS could not create a reader for topic '" + flow_.topic + "'",
                "see the message that DDS printed");
  return {};
}

void RawReader::take(const Bytes& bytes) {
  is_sample_ = model::is_sample(flow_.type, bytes.data, bytes.size);
  if (is_sample_) receiver_.receive(bytes);
}

void RawReader::on_data_available(fast::DataReader* from) {
  const std::lock_guard lock{calling_};
  fast::SampleInfo info;
  while (take_sample(*from, static_cast<Taker*>(this), info)) {
    const rtps::SampleIdentity& own = info.sample_identity;
    const rtps::SampleIdentity& given = info.related_sample_identity;
    health_.lost(sent_.before(own));
    const bool is_given = given.writer_guid() != rtps::GUID_t::unknown();
    if (const auto missing = written_.before(is_given ? given : own); missing > 0) receiver_.lost(missing);
    if (!info.valid_data) continue;
    if (!is_sample_) {
      health_.refused();
      receiver_.lost(1);
      continue;
    }
    health_.moved();
    receiver_.received(info.source_timestamp.to_ns());
  }
  receiver_.done();
}

void RawReader::on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) {
  health_.matched(status.current_count);
}

void RawReader::on_requested_incompatible_qos(fast::DataReader*,
                                              const fast::RequestedIncompatibleQosStatus& status) {
  health_.incompatible(status.last_policy_id);
}

}  // namespace takt::dds
