#include <takt/dds/gateway.hpp>

#include <atomic>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <utility>

#include "raw.hpp"
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/real_time.hpp>

namespace takt::dds {

namespace {

constexpr int kAtOnce = 16;  // samples to move from one link before the turn of the next link
constexpr Nanoseconds kLongestSleep = std::chrono::milliseconds{100};
// In ns. If a sample's time stamp is older than this, the writer's clock must differ from this machine's
// clock.
constexpr std::int64_t kOldest = std::int64_t{60} * 1'000'000'000;

/// The time on the wall clock and on the monotonic clock, read at the same moment.
struct Now {
  std::int64_t wall_ns =
      std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  std::int64_t monotonic_ns = to_ns(os::now());

  [[nodiscard]] std::int64_t wall_of(std::int64_t monotonic) const {
    return wall_ns - (monotonic_ns - monotonic);
  }
  [[nodiscard]] std::int64_t monotonic_of(std::int64_t wall) const {
    const std::int64_t age = wall_ns - wall;
    return age >= 0 && age < kOldest ? monotonic_ns - age : monotonic_ns;
  }
};

void ring(channel::WakeWord& wake_word, std::uint32_t bits) noexcept {
  wake_word.rings.fetch_add(1, std::memory_order_seq_cst);
  os::futex_wake(wake_word.rings, bits);
}

Result<void> fits(const Flow& flow, const channel::Link& link) {
  const std::size_t size = model::max_size(flow.type);
  if (link.stride() >= size) return {};
  return fail("samples of type '" + flow.type.name + "' have up to " + std::to_string(size) +
              " bytes, but the link of topic '" + flow.topic + "' holds samples of at most " +
              std::to_string(link.stride()));
}

/// An outgoing flow: moves samples from one link to DDS.
class Outgoing {
 public:
  Outgoing(std::unique_ptr<RawWriter> writer, channel::Link from) : writer_(std::move(writer)), from_(from) {}

  [[nodiscard]] std::int64_t news_at() const noexcept { return from_.news_at(); }
  [[nodiscard]] wire::FlowHealth health() const { return writer_->health(); }

  /// Moves up to kAtOnce samples. Returns false if the link had none.
  bool move() {
    const Now now;
    if (!from_.take(now.monotonic_ns)) return false;
    int moved = 0;
    do {
      const channel::SampleInfo info = from_.info();
      writer_->write({from_.link().payload(from_.buffer()), info.size}, now.wall_of(info.stamp_ns));
    } while (++moved < kAtOnce && from_.take(now.monotonic_ns));
    return true;
  }

 private:
  std::unique_ptr<RawWriter> writer_;
  channel::LinkReader from_;
};

/// An incoming flow: moves samples from DDS to one or more links.
class Incoming final : RawReader::Receiver {
 public:
  Incoming(const std::vector<channel::Link>& to, channel::WakeWord& wake_word) : wake_word_(wake_word) {
    for (const channel::Link& link : to) to_.push_back({channel::LinkWriter{link}});
  }
  Result<void> start(std::shared_ptr<Participant> participant, const Flow& flow) {
    auto made = RawReader::create(std::move(participant), flow, *this);
    if (!made) return made.problems();
    reader_ = std::move(*made);
    return {};
  }
  [[nodiscard]] wire::FlowHealth health() const { return reader_->health(); }

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
      // Alignment bytes at the end may make a sample longer than the largest sample of its type.
      end.size = static_cast<std::uint32_t>(std::min<std::size_t>(bytes.size, link.stride()));
      std::memcpy(link.payload(end.writer.buffer()), bytes.data, end.size);
    }
  }
  void received(std::int64_t time_ns) override {
    const std::int64_t stamp = Now{}.monotonic_of(time_ns);
    for (End& end : to_) {
      if (end.size == 0) continue;
      end.writer.publish(end.size, stamp);
      to_ring_ |= end.writer.link().block().wake_bits;
    }
  }
  void done() override {
    if (const std::uint32_t bits = std::exchange(to_ring_, 0); bits != 0) ring(wake_word_, bits);
  }

  channel::WakeWord& wake_word_;
  std::vector<End> to_;
  std::uint32_t to_ring_ = 0;
  // Must be the last member: the reader calls this object until the reader is destroyed.
  std::unique_ptr<RawReader> reader_;
};

class OwnGateway final : public Gateway {
 public:
  OwnGateway(std::shared_ptr<Participant> participant, channel::WakeWord& wake_word, std::uint32_t place)
      : participant_(std::move(participant)), wake_word_(wake_word), sleeps_(1U << place) {}

  Result<void> start() {
    auto started = os::Thread::start(
        {.name = "takt-gateway"}, [this] { pump(); }, nullptr);
    if (!started) return started.problems();
    pump_ = std::move(*started);
    return {};
  }

  ~OwnGateway() override {
    ending_ = true;
    ring(wake_word_, channel::kGatewayBit);
    pump_.join();
  }

  Result<FlowId> add_outgoing(const Flow& flow, channel::Link from) override {
    if (auto fit = fits(flow, from); !fit) return fit.problems();
    auto writer = RawWriter::create(participant_, flow);
    if (!writer) return writer.problems();
    auto made = std::make_unique<Outgoing>(std::move(*writer), from);
    const std::lock_guard lock{mutex_};
    outgoing_[++last_id_] = std::move(made);
    return last_id_;
  }

  Result<FlowId> add_incoming(const Flow& flow, std::vector<channel::Link> to) override {
    for (const channel::Link& link : to) {
      if (auto fit = fits(flow, link); !fit) return fit.problems();
    }
    auto made = std::make_unique<Incoming>(to, wake_word_);
    if (auto started = made->start(participant_, flow); !started) return started.problems();
    const std::lock_guard lock{mutex_};
    incoming_[++last_id_] = std::move(made);
    return last_id_;
  }

  void remove(FlowId flow) override {
    // These are declared before the lock, so that the flow is deleted after the mutex is unlocked: the
    // deletion waits for callbacks, which may need the mutex.
    std::unique_ptr<Outgoing> outgoing;
    std::unique_ptr<Incoming> incoming;
    const std::lock_guard lock{mutex_};
    if (const auto found = outgoing_.find(flow); found != outgoing_.end()) {
      outgoing = std::move(found->second);
      outgoing_.erase(found);
    } else if (const auto other = incoming_.find(flow); other != incoming_.end()) {
      incoming = std::move(other->second);
      incoming_.erase(other);
    }
  }

  wire::FlowHealth health(FlowId flow) const override {
    const std::lock_guard lock{mutex_};
    if (const auto found = outgoing_.find(flow); found != outgoing_.end()) return found->second->health();
    if (const auto found = incoming_.find(flow); found != incoming_.end()) return found->second->health();
    return {};
  }

 private:
  void pump() {
    while (!ending_.load()) {
      const std::uint32_t rings = wake_word_.rings.load(std::memory_order_seq_cst);
      if (move()) continue;
      // SYNC: gateway sleeps. A writer publishes a sample and then reads gateway_sleeps. So either the writer
      // sees this bit and rings, or this thread sees the sample.
      wake_word_.gateway_sleeps.fetch_or(sleeps_, std::memory_order_seq_cst);
      const Instant now = os::now();
      const std::int64_t news = news_at();
      if (news > to_ns(now) && !ending_.load()) {
        // kLongestSleep limits the delay of a sample if the host that wrote it died before it rang the wake
        // word.
        const Instant until = std::min(now + kLongestSleep, from_ns(news));
        os::futex_wait(wake_word_.rings, rings, channel::kGatewayBit, until);
      }
      wake_word_.gateway_sleeps.fetch_and(~sleeps_, std::memory_order_seq_cst);
    }
  }
  bool move() {
    const std::lock_guard lock{mutex_};
    bool moved = false;
    for (auto& [id, flow] : outgoing_) moved = flow->move() || moved;
    return moved;
  }
  /// Returns the earliest time at which a sample of an outgoing flow may be read.
  std::int64_t news_at() {
    const std::lock_guard lock{mutex_};
    std::int64_t first = channel::kNever;
    for (const auto& [id, flow] : outgoing_) first = std::min(first, flow->news_at());
    return first;
  }

  std::shared_ptr<Participant> participant_;
  channel::WakeWord& wake_word_;
  const std::uint32_t sleeps_;  // this gateway's bit of WakeWord::gateway_sleeps
  mutable std::mutex mutex_;
  FlowId last_id_ = 0;
  std::map<FlowId, std::unique_ptr<Outgoing>> outgoing_;
  std::map<FlowId, std::unique_ptr<Incoming>> incoming_;
  std::atomic<bool> ending_{false};
  os::Thread pump_;
};

class OwnTap final : public Tap, RawReader::Receiver {
 public:
  explicit OwnTap(std::function<void(const std::byte*, std::size_t, std::int64_t)> sample)
      : sample_(std::move(sample)) {}
  Result<void> start(std::shared_ptr<Participant> participant, const Flow& flow) {
    auto made = RawReader::create(std::move(participant), flow, *this);
    if (!made) return made.problems();
    reader_ = std::move(*made);
    return {};
  }
  wire::FlowHealth health() const override { return reader_->health(); }

 private:
  void receive(const Bytes& bytes) override { bytes_.assign(bytes.data, bytes.data + bytes.size); }
  void received(std::int64_t time_ns) override { sample_(bytes_.data(), bytes_.size(), time_ns); }

  std::function<void(const std::byte*, std::size_t, std::int64_t)> sample_;
  std::vector<std::byte> bytes_;
  std::unique_ptr<RawReader> reader_;  // must be the last member: the reader calls this object until it is
                                       // destroyed
};

class OwnFeed final : public Feed {
 public:
  explicit OwnFeed(std::unique_ptr<RawWriter> writer) : writer_(std::move(writer)) {}
  bool write(const std::byte* bytes, std::size_t size, std::int64_t time_ns) override {
    return writer_->write({bytes, size}, time_ns == 0 ? Now{}.wall_ns : time_ns);
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
    std::function<void(const std::byte*, std::size_t, std::int64_t)> sample) {
  auto made = std::make_unique<OwnTap>(std::move(sample));
  if (auto started = made->start(std::move(participant), flow); !started) return started.problems();
  return std::unique_ptr<Tap>{std::move(made)};
}

Result<std::unique_ptr<Feed>> Feed::create(std::shared_ptr<Participant> participant, const Flow& flow) {
  auto writer = RawWriter::create(std::move(participant), flow);
  if (!writer) return writer.problems();
  return std::unique_ptr<Feed>{std::make_unique<OwnFeed>(std::move(*writer))};
}

}  // namespace takt::dds
