#include <takt/dds/gateway.hpp>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

#include "outgoing_flows.hpp"
#include "raw.hpp"

namespace takt::dds {

namespace {

Result<void> fits(const Flow& flow, const channel::Link& link) {
  const std::size_t size = model::max_size(flow.type);
  if (link.stride() >= size) return {};
  return fail("samples of type '" + flow.type.name + "' have up to " + std::to_string(size) +
              " bytes, but the link of topic '" + flow.topic + "' holds samples of at most " +
              std::to_string(link.stride()));
}

/// An incoming flow: moves samples from DDS to one or more links.
class Incoming final : RawReader::Receiver {
 public:
  Incoming(const std::vector<channel::Link>& to, std::optional<Nanoseconds> lifespan,
           channel::WakeWord& wake_word)
      : wake_word_(wake_word), lifespan_(lifespan) {
    for (const channel::Link& link : to) to_.push_back({channel::LinkWriter{link}});
  }
  Result<void> start(std::shared_ptr<Participant> participant, const Flow& flow) {
    auto made = RawReader::create(std::move(participant), flow, *this);
    if (!made) return made.problems();
    reader_ = std::move(*made);
    return {};
  }
  [[nodiscard]] wire::FlowHealth health() const {
    wire::FlowHealth health = reader_->health();
    health.lost += expired_.load(std::memory_order_relaxed);
    health.untimed = untimed_.load(std::memory_order_relaxed);
    return health;
  }

 private:
  struct End {
    channel::LinkWriter writer;
    std::uint32_t size = 0;  // bytes of the sample in the writer's buffer; 0 if the buffer holds none
  };

  // Copies the bytes of a sample into the writer's buffer of each link. Readers of the links see the sample
  // only after received() has published it.
  void receive(const Bytes& bytes) override {
    for (End& end : to_) {
      const channel::Link& link = end.writer.link();
      end.size = 0;
      if (link.block().enabled.load(std::memory_order_relaxed) == 0) continue;
      // Alignment bytes at the end may make a sample longer than the largest sample of its type. They need
      // not be copied.
      end.size = static_cast<std::uint32_t>(std::min<std::size_t>(bytes.size, link.stride()));
      std::memcpy(link.payload(end.writer.buffer()), bytes.data, end.size);
    }
  }
  void received(std::int64_t time_ns) override {
    const Now now;
    bool untimed = false;
    bool expired = false;
    for (End& end : to_) {
      if (end.size == 0) continue;
      const channel::LinkBlock& block = end.writer.link().block();
      const auto written = now.monotonic_of(time_ns, block.sender_clock_ns.load(std::memory_order_relaxed));
      untimed |= !written;
      const std::int64_t stamp = written.value_or(now.monotonic_ns);
      if (lifespan_ && Nanoseconds{now.monotonic_ns - stamp} > *lifespan_) {
        expired = true;
        continue;
      }
      end.writer.publish(end.size, stamp);
      to_ring_ |= block.wake_bits;
    }
    if (untimed) untimed_.fetch_add(1, std::memory_order_relaxed);
    if (expired) expired_.fetch_add(1, std::memory_order_relaxed);
  }
  void done() override {
    if (const std::uint32_t bits = std::exchange(to_ring_, 0); bits != 0) ring(wake_word_, bits);
  }

  channel::WakeWord& wake_word_;
  const std::optional<Nanoseconds> lifespan_;
  std::atomic<std::uint64_t> expired_{0};  // samples that were older than the lifespan when they arrived
  std::atomic<std::uint64_t> untimed_{0};
  std::vector<End> to_;
  std::uint32_t to_ring_ = 0;
  // Must be the last member, because the reader calls this object until the reader is destroyed.
  std::unique_ptr<RawReader> reader_;
};

class OwnGateway final : public Gateway {
 public:
  OwnGateway(std::shared_ptr<Participant> participant, channel::WakeWord& wake_word, std::uint32_t place)
      : participant_(std::move(participant)), wake_word_(wake_word), outgoing_(wake_word, place) {}

  Result<void> start() { return outgoing_.start(); }

  Result<FlowId> add_outgoing(const Flow& flow, channel::Link from) override {
    if (auto fit = fits(flow, from); !fit) return fit.problems();
    auto writer = RawWriter::create(participant_, flow);
    if (!writer) return writer.problems();
    const FlowId id = ++last_id_;
    outgoing_.add(id, std::move(*writer), from);
    return id;
  }

  Result<FlowId> add_incoming(const Flow& flow, std::vector<channel::Link> to) override {
    for (const channel::Link& link : to) {
      if (auto fit = fits(flow, link); !fit) return fit.problems();
    }
    auto made = std::make_unique<Incoming>(to, flow.quality.lifespan, wake_word_);
    if (auto started = made->start(participant_, flow); !started) return started.problems();
    const FlowId id = ++last_id_;
    const std::lock_guard lock{mutex_};
    incoming_[id] = std::move(made);
    return id;
  }

  void thin_out(FlowId flow, Nanoseconds every) override { outgoing_.thin_out(flow, every); }

  void remove(FlowId flow) override {
    outgoing_.remove(flow);
    // Declared before the lock, so that the flow is deleted after the mutex is unlocked. The deletion waits
    // for callbacks, and this thread must not hold the mutex during this wait.
    std::unique_ptr<Incoming> incoming;
    const std::lock_guard lock{mutex_};
    if (const auto found = incoming_.find(flow); found != incoming_.end()) {
      incoming = std::move(found->second);
      incoming_.erase(found);
    }
  }

  wire::FlowHealth health(FlowId flow) const override {
    if (const auto health = outgoing_.health(flow)) return *health;
    const std::lock_guard lock{mutex_};
    const auto found = incoming_.find(flow);
    return found == incoming_.end() ? wire::FlowHealth{} : found->second->health();
  }

 private:
  std::shared_ptr<Participant> participant_;
  channel::WakeWord& wake_word_;
  std::atomic<FlowId> last_id_{0};
  mutable std::mutex mutex_;
  std::map<FlowId, std::unique_ptr<Incoming>> incoming_;
  OutgoingFlows outgoing_;
};

class OwnTap final : public Tap, RawReader::Receiver {
 public:
  OwnTap(std::function<void(const std::byte*, std::size_t, std::int64_t)> sample,
         std::function<void(std::uint64_t)> lost)
      : sample_(std::move(sample)), lost_(std::move(lost)) {}
  Result<void> start(std::shared_ptr<Participant> participant, const Flow& flow) {
    auto made = RawReader::create(std::move(participant), flow, *this);
    if (!made) return made.problems();
    reader_ = std::move(*made);
    return {};
  }
  wire::FlowHealth health() const override { return reader_->health(); }

 private:
  void lost(std::uint64_t count) override {
    if (lost_) lost_(count);
  }
  void receive(const Bytes& bytes) override { bytes_.assign(bytes.data, bytes.data + bytes.size); }
  void received(std::int64_t time_ns) override { sample_(bytes_.data(), bytes_.size(), time_ns); }

  std::function<void(const std::byte*, std::size_t, std::int64_t)> sample_;
  std::function<void(std::uint64_t)> lost_;
  std::vector<std::byte> bytes_;
  std::unique_ptr<RawReader> reader_;  // must be the last member: the reader calls this object until it is
                                       // destroyed
};

class OwnFeed final : public Feed {
 public:
  explicit OwnFeed(std::unique_ptr<RawWriter> writer) : writer_(std::move(writer)) {}
  bool write(const std::byte* bytes, std::size_t size, std::int64_t time_ns) override {
    return writer_->write({bytes, size}, time_ns == 0 ? Now{}.wall_ns : time_ns, 0);
  }
  wire::FlowHealth health() const override { return writer_->health(); }

 private:
  std::unique_ptr<RawWriter> writer_;
};

}  // namespace

Result<std::unique_ptr<Gateway>> Gateway::create(std::shared_ptr<Participant> participant,
                                                 channel::WakeWord& wake_word, std::uint32_t place) {
  auto made = std::make_unique<OwnGateway>(std::move(participant), wake_word, place);
  if (auto started = made->start(); !started) return started.problems();
  return std::unique_ptr<Gateway>{std::move(made)};
}

Result<std::unique_ptr<Tap>> Tap::create(
    std::shared_ptr<Participant> participant, const Flow& flow,
    std::function<void(const std::byte*, std::size_t, std::int64_t)> sample,
    std::function<void(std::uint64_t)> lost) {
  auto made = std::make_unique<OwnTap>(std::move(sample), std::move(lost));
  if (auto started = made->start(std::move(participant), flow); !started) return started.problems();
  return std::unique_ptr<Tap>{std::move(made)};
}

Result<std::unique_ptr<Feed>> Feed::create(std::shared_ptr<Participant> participant, const Flow& flow) {
  auto writer = RawWriter::create(std::move(participant), flow);
  if (!writer) return writer.problems();
  return std::unique_ptr<Feed>{std::make_unique<OwnFeed>(std::move(*writer))};
}

}  // namespace takt::dds
