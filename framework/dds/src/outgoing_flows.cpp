#include "outgoing_flows.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include <takt/core/span.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>

namespace takt::dds {

namespace {

// The maximum number of samples that are moved from one link before the next link has its turn.
constexpr int kAtOnce = 16;
constexpr Nanoseconds kLongestSleep = std::chrono::milliseconds{100};
// The maximum age of a time stamp, in ns.
constexpr std::int64_t kOldest = std::int64_t{60} * 1'000'000'000;

}  // namespace

Now::Now() : wall_ns(os::wall_ns()), monotonic_ns(to_ns(os::now())) {}

std::optional<std::int64_t> Now::monotonic_of(std::int64_t wall, std::int64_t writer_clock) const {
  const std::int64_t age =
      writer_clock == 0 ? wall_ns - wall : span(wall - writer_clock, monotonic_ns).count();
  return age >= 0 && age < kOldest ? std::optional{monotonic_ns - age} : std::nullopt;
}

void ring(channel::WakeWord& wake_word, std::uint32_t bits) noexcept {
  wake_word.rings.fetch_add(1, std::memory_order_seq_cst);
  os::futex_wake(wake_word.rings, bits);
}

class OutgoingFlows::Outgoing {
 public:
  Outgoing(std::unique_ptr<SampleWriter> writer, channel::Link from)
      : writer_(std::move(writer)), from_(from) {}

  [[nodiscard]] wire::FlowHealth health() const { return writer_->health(); }

  /// Moves up to kAtOnce samples. Returns false if the link had no sample.
  bool move() {
    const std::lock_guard lock{moving_};
    const Now now;
    const std::int64_t every = every_ns_.load(std::memory_order_relaxed);
    if (closed_ || (every != 0 && now.monotonic_ns < moved_ns_ + every) || !from_.take(now.monotonic_ns))
      return false;
    if (every != 0) {
      for (std::uint32_t i = 0; i < from_.link().depth() && from_.take(now.monotonic_ns); ++i) {
      }
      write(now);
      moved_ns_ = now.monotonic_ns;
      return true;
    }
    int moved = 0;
    do {
      write(now);
    } while (++moved < kAtOnce && from_.take(now.monotonic_ns));
    return true;
  }
  /// See Gateway::thin_out().
  void thin_out(Nanoseconds every) { every_ns_.store(every.count(), std::memory_order_relaxed); }
  [[nodiscard]] bool is_thinned() const { return every_ns_.load(std::memory_order_relaxed) != 0; }
  /// Returns the time from which the next sample of the link may be read; channel::kNever if there is none.
  std::int64_t news_at() {
    const std::lock_guard lock{moving_};
    if (closed_) return channel::kNever;
    const std::int64_t news = from_.news_at();
    const std::int64_t every = every_ns_.load(std::memory_order_relaxed);
    return every == 0 ? news : std::max(news, moved_ns_ + every);
  }
  /// Ends the use of the link. Waits for the write of a sample.
  void close() {
    const std::lock_guard lock{moving_};
    closed_ = true;
  }

 private:
  void write(const Now& now) {
    const channel::SampleInfo info = from_.info();
    writer_->write({from_.link().payload(from_.buffer()), info.size}, now.wall_of(info.stamp_ns),
                   info.sequence);
  }

  std::mutex moving_;  // held during writes
  bool closed_ = false;
  std::atomic<std::int64_t> every_ns_{0};  // 0: every sample is moved
  /// If not every sample is moved: when the last one was.
  std::int64_t moved_ns_ = std::numeric_limits<std::int64_t>::min() / 2;
  std::unique_ptr<SampleWriter> writer_;
  channel::LinkReader from_;
};

OutgoingFlows::OutgoingFlows(channel::WakeWord& wake_word, std::uint32_t place) noexcept
    : wake_word_(wake_word), sleeps_(1U << place) {}

OutgoingFlows::~OutgoingFlows() {
  ending_ = true;
  ring(wake_word_, channel::kGatewayBit);
  pump_.join();
}

Result<void> OutgoingFlows::start() {
  auto started = os::Thread::start(
      {.name = "takt-gateway"}, [this] { pump(); }, nullptr);
  if (!started) return started.problems();
  pump_ = std::move(*started);
  return {};
}

void OutgoingFlows::add(FlowId id, std::unique_ptr<SampleWriter> writer, channel::Link from) {
  auto made = std::make_shared<Outgoing>(std::move(writer), from);
  {
    const std::lock_guard lock{mutex_};
    flows_[id] = std::move(made);
    changed_ = true;
  }
  ring(wake_word_, channel::kGatewayBit);
}

void OutgoingFlows::thin_out(FlowId id, Nanoseconds every) {
  {
    const std::lock_guard lock{mutex_};
    if (const auto found = flows_.find(id); found != flows_.end()) found->second->thin_out(every);
  }
  ring(wake_word_, channel::kGatewayBit);
}

void OutgoingFlows::remove(FlowId id) {
  std::shared_ptr<Outgoing> removed;
  {
    const std::lock_guard lock{mutex_};
    const auto found = flows_.find(id);
    if (found == flows_.end()) return;
    removed = std::move(found->second);
    flows_.erase(found);
    changed_ = true;
  }
  removed->close();
  ring(wake_word_, channel::kGatewayBit);
}

std::optional<wire::FlowHealth> OutgoingFlows::health(FlowId id) const {
  const std::lock_guard lock{mutex_};
  const auto found = flows_.find(id);
  return found == flows_.end() ? std::nullopt : std::optional{found->second->health()};
}

void OutgoingFlows::pump() {
  Flows flows;
  while (!ending_.load()) {
    const std::uint32_t rings = wake_word_.rings.load(std::memory_order_seq_cst);
    refresh(flows);
    bool moved = false;
    for (const auto& flow : flows) moved = flow->move() || moved;
    if (moved) continue;
    // This thread sets its bit and then checks for samples. A writer publishes a sample and then reads
    // gateway_sleeps. So either the writer sees this bit and wakes this thread, or this thread sees the
    // sample. No writer needs to wake this thread if it moves only the newest sample of each flow.
    if (!std::all_of(flows.begin(), flows.end(), [](const auto& flow) { return flow->is_thinned(); }))
      wake_word_.gateway_sleeps.fetch_or(sleeps_, std::memory_order_seq_cst);
    const Instant now = os::now();
    std::int64_t news = channel::kNever;
    for (const auto& flow : flows) news = std::min(news, flow->news_at());
    if (news > to_ns(now) && !ending_.load()) {
      // kLongestSleep limits the delay of a sample whose host died after it wrote the sample and before it
      // woke this thread.
      const Instant until = std::min(now + kLongestSleep, from_ns(news));
      os::futex_wait(wake_word_.rings, rings, channel::kGatewayBit, until);
    }
    wake_word_.gateway_sleeps.fetch_and(~sleeps_, std::memory_order_seq_cst);
  }
}

/// Updates the pump's list of flows.
void OutgoingFlows::refresh(Flows& flows) {
  Flows before;  // declared before the lock, so that removed flows are destroyed after the mutex is unlocked
  const std::lock_guard lock{mutex_};
  if (!std::exchange(changed_, false)) return;
  before.swap(flows);
  for (const auto& [id, flow] : flows_) flows.push_back(flow);
}

}  // namespace takt::dds
