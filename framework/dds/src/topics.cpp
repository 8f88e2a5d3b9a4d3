#include <takt/dds/topics.hpp>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include <takt/wire/takt.h>
#include <takt/wire/taktPubSubTypes.h>
#include <takt/wire/validation.hpp>
#include "discovery_listener.hpp"
#include "inside.hpp"
#include "workarounds/checked_type.hpp"
#include "workarounds/disposed_keys.hpp"
#include "workarounds/heartbeats.hpp"

namespace takt::dds {

namespace {

/// The maximum number of keys of a topic, for example one for each module on a domain. The default of Fast
/// DDS is 10 keys; Fast DDS would drop the samples of further keys.
constexpr int kMaxKeys = 16384;
constexpr Nanoseconds kLease = std::chrono::milliseconds{300};
/// The depth of a reader's history. It must be so large that the listener takes the samples of a burst before
/// newer samples overwrite them.
constexpr std::int32_t kReaderDepth = 64;
constexpr std::int32_t kEventsKept = 64;  ///< number of events per device that a reader gets when it joins
                                          ///< later
constexpr Nanoseconds kTopicHeartbeat = std::chrono::milliseconds{20};
/// Readers acknowledge a repeated state once in this time, unless the writer asks.
constexpr Nanoseconds kRepeatedHeartbeat = std::chrono::seconds{3};
constexpr Nanoseconds kAskAgain = std::chrono::milliseconds{20};

/// The kinds of topics. DDS keeps the last state of each key and the last events for readers that join later,
/// but does not keep measurements. For states, DDS also checks that the writer is alive. A repeated state is
/// written ten times a second, so a reader need not acknowledge each sample.
enum class Sort { state, repeated_state, measure, event };

constexpr bool is_state(Sort sort) { return sort == Sort::state || sort == Sort::repeated_state; }

/// The name, kind and generated type of the topic with samples of type T.
template <class T>
struct TopicOf;
template <>
struct TopicOf<LifecycleStatus> {
  using Generated = LifecycleStatusPubSubType;
  static constexpr const char* name = "takt/lifecycle";
  static constexpr Sort sort = Sort::state;
};
template <>
struct TopicOf<DeviceStatus> {
  using Generated = DeviceStatusPubSubType;
  static constexpr const char* name = "takt/device";
  static constexpr Sort sort = Sort::repeated_state;
};
template <>
struct TopicOf<ModuleStatistics> {
  using Generated = ModuleStatisticsPubSubType;
  static constexpr const char* name = "takt/statistics";
  static constexpr Sort sort = Sort::measure;
};
template <>
struct TopicOf<ExecutorStatistics> {
  using Generated = ExecutorStatisticsPubSubType;
  static constexpr const char* name = "takt/executor";
  static constexpr Sort sort = Sort::measure;
};
template <>
struct TopicOf<PortStatus> {
  using Generated = PortStatusPubSubType;
  static constexpr const char* name = "takt/port";
  static constexpr Sort sort = Sort::measure;
};
template <>
struct TopicOf<FaultEvent> {
  using Generated = FaultEventPubSubType;
  static constexpr const char* name = "takt/fault";
  static constexpr Sort sort = Sort::event;
};

template <class T, class Qos>
void set_topic_quality(Qos& qos, std::int32_t depth) {
  constexpr bool kKept = TopicOf<T>::sort != Sort::measure;
  qos.reliability().kind = kKept ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = kKept ? fast::TRANSIENT_LOCAL_DURABILITY_QOS : fast::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  if (is_state(TopicOf<T>::sort)) {
    qos.liveliness().kind = fast::MANUAL_BY_TOPIC_LIVELINESS_QOS;
    qos.liveliness().lease_duration = duration(kLease);
    qos.liveliness().announcement_period = duration(kLease / 3);
  }
  qos.resource_limits().max_instances = kMaxKeys;
  qos.resource_limits().max_samples_per_instance = depth;
  qos.resource_limits().max_samples = kMaxKeys * depth;
  qos.resource_limits().allocated_samples = 16;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
}

template <class T>
fast::TypeSupport type_of() {
  return fast::TypeSupport{new CheckedType<typename TopicOf<T>::Generated>};
}

/// Returns the device in a path: "robot" for "cell/robot" and "cell/robot/arm"; "" if the path names no
/// device.
std::string device_in(std::string_view path) {
  const std::size_t begin = path.find('/');
  if (begin == std::string_view::npos) return {};
  const std::string_view rest = path.substr(begin + 1);
  return std::string{rest.substr(0, rest.find('/'))};
}

/// Returns true if the writer may publish this sample; otherwise reports the writer. With DDS Security, all
/// devices may write these topics, but each device may publish only samples about itself.
template <class T>
bool may_publish(OwnParticipant& participant, const rtps::GUID_t& writer, const T& sample) {
  DiscoveryListener* const listener = participant.discovery_listener();
  if (listener == nullptr) return true;
  const std::string path = sample.path().to_string();
  const std::string device = device_in(path);
  const bool named = sample.device().size() == 0 ||
                     sample.device().to_string() == device;  // a disposal has an empty device name
  if (named && listener->is_device(writer, device)) return true;
  listener->impostor(writer, TopicOf<T>::name, path);
  return false;
}

template <class T>
Problem no_entity(const char* what) {
  return fail(std::string{"DDS could not create a "} + what + " for topic " + TopicOf<T>::name,
              "see the message that DDS printed");
}

}  // namespace

template <class T>
struct Writer<T>::Inside final {
  static constexpr bool kIsRepeated = TopicOf<T>::sort == Sort::repeated_state;

  std::shared_ptr<Participant> participant;
  fast::Topic* topic = nullptr;
  fast::DataWriter* writer = nullptr;
  std::atomic<std::uint64_t> failures{0};

  ~Inside() {
    own(*participant).end(writer);
    if (topic != nullptr) own(*participant).release(topic);
  }

  Result<void> make() {
    fast::DataWriterQos qos;
    set_topic_quality<T>(qos, TopicOf<T>::sort == Sort::event ? kEventsKept : 1);
    qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
    set_times(qos, kIsRepeated ? kRepeatedHeartbeat : kTopicHeartbeat);
    qos.writer_data_lifecycle().autodispose_unregistered_instances = true;
    writer = own(*participant).make_writer(topic, qos, nullptr, fast::StatusMask::none());
    if (writer == nullptr) return no_entity<T>("writer");
    return {};
  }
};

template <class T>
Result<Writer<T>> Writer<T>::create(std::shared_ptr<Participant> participant) {
  auto inside = std::make_unique<Inside>();
  inside->participant = std::move(participant);
  OwnParticipant& mine = own(*inside->participant);
  auto topic = mine.topic(TopicOf<T>::name, type_of<T>());
  if (!topic) return topic.problems();
  inside->topic = *topic;
  if (auto made = inside->make(); !made) return made.problems();
  return Writer{std::move(inside)};
}

template <class T>
Writer<T>::Writer(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}
template <class T>
Writer<T>::Writer(Writer&&) noexcept = default;
template <class T>
Writer<T>& Writer<T>::operator=(Writer&&) noexcept = default;
template <class T>
Writer<T>::~Writer() = default;

template <class T>
bool Writer<T>::write(const T& sample) {
  const HeartbeatsAsk which{Inside::kIsRepeated ? Answers::if_sample_is_missing : Answers::as_usual};
  const bool taken = write_sample(*inside_->writer, &sample);
  if (!taken) inside_->failures.fetch_add(1, std::memory_order_relaxed);
  return taken;
}

template <class T>
void Writer<T>::dispose(const T& sample) {
  T copy = sample;
  const SentKey key{copy.path().c_str()};
  inside_->writer->dispose(&copy, inside_->writer->lookup_instance(&copy));
  inside_->writer->unregister_instance(&copy, rtps::c_InstanceHandle_Unknown);
}

template <class T>
void Writer<T>::assert_liveliness() {
  static_cast<void>(inside_->writer->assert_liveliness());
}

template <class T>
bool Writer<T>::wait_acknowledged(std::chrono::milliseconds limit) {
  if (!is_state(TopicOf<T>::sort)) return wait_for_readers(*inside_->writer, limit);
  const Nanoseconds ask_again = Inside::kIsRepeated ? kAskAgain : Nanoseconds{limit};
  for (Nanoseconds left = limit; left > Nanoseconds{0}; left -= ask_again) {
    const HeartbeatsAsk all{Answers::always};
    assert_liveliness();
    if (wait_for_readers(*inside_->writer, std::min(left, ask_again))) return true;
  }
  return false;
}

template <class T>
std::uint64_t Writer<T>::failures() const noexcept {
  return inside_->failures.load(std::memory_order_relaxed);
}

template <class T>
struct Reader<T>::Inside final : fast::DataReaderListener {
  std::shared_ptr<Participant> participant;
  Callbacks<T> callbacks;
  fast::Topic* topic = nullptr;
  fast::DataReader* reader = nullptr;
  std::atomic<int> matched{0};
  std::mutex calling;  // locks the callbacks, because DDS reports data and status on different threads
  T sample;
  std::set<wire::WriterId> living;
  Undecoded* undecoded = nullptr;
  std::atomic<std::uint64_t> refused{0};
  // The path of each instance, by handle. A path is stored because a disposal contains only the handle.
  std::map<rtps::InstanceHandle_t, std::string> paths;

  ~Inside() override {
    own(*participant).end(reader);
    if (topic != nullptr) own(*participant).release(topic);
  }

  Result<void> make() {
    fast::DataReaderQos qos;
    set_topic_quality<T>(qos, kReaderDepth);
    // The lease of the device's status shows whether its node lives; a second one for each node costs time.
    if (TopicOf<T>::sort == Sort::state) qos.liveliness() = {};
    set_times(qos, Nanoseconds{0});
    fast::StatusMask mask = fast::StatusMask::data_available();
    mask << fast::StatusMask::liveliness_changed() << fast::StatusMask::subscription_matched();
    reader = own(*participant).make_reader(topic, qos, this, mask, Receives::in_group);
    if (reader == nullptr) return no_entity<T>("reader");
    return {};
  }

  void lives(wire::WriterId writer) {
    if (living.insert(writer).second && callbacks.alive) callbacks.alive(writer);
  }
  void is_lost(wire::WriterId writer) {
    if (living.erase(writer) > 0 && callbacks.lost) callbacks.lost(writer);
  }

  void on_data_available(fast::DataReader* from) override {
    const std::lock_guard lock{calling};
    fast::SampleInfo info;
    while (take_sample(*from, &sample, info)) {
      const wire::WriterId writer = number_of(info.sample_identity.writer_guid());
      if (info.valid_data) {
        if (!wire::validate(sample) ||
            !may_publish(own(*participant), info.sample_identity.writer_guid(), sample)) {
          refused.fetch_add(1, std::memory_order_relaxed);
          continue;
        }
        if constexpr (std::is_same_v<T, DeviceStatus>)
          own(*participant)
              .is_device(info.sample_identity.writer_guid().guidPrefix, sample.device().to_string());
        lives(writer);
        if (callbacks.disposed) paths[info.instance_handle] = sample.path().to_string();
        callbacks.sample(sample, writer);
      } else if (const auto found = paths.find(info.instance_handle);
                 info.instance_state == fast::NOT_ALIVE_DISPOSED_INSTANCE_STATE && found != paths.end()) {
        T gone;
        gone.path(found->second.c_str());
        if (!may_publish(own(*participant), info.sample_identity.writer_guid(), gone)) continue;
        paths.erase(found);
        callbacks.disposed(gone, writer);
      }
    }
  }

  void on_liveliness_changed(fast::DataReader*, const fast::LivelinessChangedStatus& status) override {
    const std::lock_guard lock{calling};
    const wire::WriterId writer = number_of(status.last_publication_handle);
    if (status.not_alive_count_change > 0) is_lost(writer);
    if (status.alive_count_change > 0) lives(writer);
  }

  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override {
    const std::lock_guard lock{calling};
    matched = status.current_count;
    if (status.current_count_change < 0) is_lost(number_of(status.last_publication_handle));
  }
};

template <class T>
Result<Reader<T>> Reader<T>::create(std::shared_ptr<Participant> participant, Callbacks<T> callbacks) {
  auto inside = std::make_unique<Inside>();
  inside->participant = std::move(participant);
  inside->callbacks = std::move(callbacks);
  OwnParticipant& mine = own(*inside->participant);
  auto topic = mine.topic(TopicOf<T>::name, type_of<T>());
  if (!topic) return topic.problems();
  inside->topic = *topic;
  inside->undecoded = &undecoded(mine.participant(), **topic);
  if (auto made = inside->make(); !made) return made.problems();
  return Reader{std::move(inside)};
}

template <class T>
Reader<T>::Reader(std::unique_ptr<Inside> inside) noexcept : inside_(std::move(inside)) {}
template <class T>
Reader<T>::Reader(Reader&&) noexcept = default;
template <class T>
Reader<T>& Reader<T>::operator=(Reader&&) noexcept = default;
template <class T>
Reader<T>::~Reader() = default;

template <class T>
int Reader<T>::matched() const noexcept {
  return inside_->matched;
}

template <class T>
std::uint64_t Reader<T>::refused() const noexcept {
  return inside_->refused.load(std::memory_order_relaxed) +
         inside_->undecoded->count.load(std::memory_order_relaxed);
}

template class Writer<LifecycleStatus>;
template class Writer<DeviceStatus>;
template class Writer<ModuleStatistics>;
template class Writer<ExecutorStatistics>;
template class Writer<PortStatus>;
template class Writer<FaultEvent>;
template class Reader<LifecycleStatus>;
template class Reader<DeviceStatus>;
template class Reader<ModuleStatistics>;
template class Reader<ExecutorStatistics>;
template class Reader<PortStatus>;
template class Reader<FaultEvent>;

}  // namespace takt::dds
