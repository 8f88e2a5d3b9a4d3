#include "outgoing_flows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <vector>

#include <takt/os/clock.hpp>

namespace takt::dds::outgoing_flows_test {
namespace {

using namespace std::chrono_literals;

/// Memory that contains a link with one sample.
class Full {
 public:
  Full() {
    const channel::Link::Options options{.depth = 4, .payload = 64, .is_queue = true};
    const std::size_t size = channel::Link::layout(options).size();
    bytes_ = static_cast<std::byte*>(::operator new (size, std::align_val_t{64}));
    std::memset(bytes_, 0, size);
    channel::Link::format(bytes_, options);
    writer_.emplace(link());
    publish();
  }
  Full(const Full&) = delete;
  Full& operator=(const Full&) = delete;
  ~Full() { ::operator delete (bytes_, std::align_val_t{64}); }
  [[nodiscard]] channel::Link link() const { return channel::Link{bytes_}; }
  void publish() { writer_->publish(8, to_ns(os::now())); }

 private:
  std::byte* bytes_ = nullptr;
  std::optional<channel::LinkWriter> writer_;
};

/// What a SlowWriter has done.
struct Watched {
  std::promise<void> writing;
  std::promise<void> may_return;
  std::promise<bool> returned_in_time;
  std::promise<void> destroyed;
};

/// A writer whose write takes until the test ends it.
class SlowWriter final : public SampleWriter {
 public:
  explicit SlowWriter(Watched& watched) : watched_(watched) {}
  ~SlowWriter() override { watched_.destroyed.set_value(); }
  bool write(const Bytes&, std::int64_t, std::uint64_t) override {
    watched_.writing.set_value();
    watched_.returned_in_time.set_value(watched_.may_return.get_future().wait_for(5s) ==
                                        std::future_status::ready);
    return true;
  }
  [[nodiscard]] wire::FlowHealth health() const override {
    wire::FlowHealth health;
    health.matched = 7;
    return health;
  }

 private:
  Watched& watched_;
};

TEST(OutgoingFlows, GiveTheirHealthDuringAWriteForWhichARemovalWaits) {
  const Full slow_link;
  const Full other_link;
  Watched slow;
  Watched other;
  channel::WakeWord wake_word{};
  OutgoingFlows flows{wake_word, 0};
  ASSERT_TRUE(flows.start().ok());
  flows.add(1, std::make_unique<SlowWriter>(slow), slow_link.link());
  slow.writing.get_future().wait();

  for (int step = 0; step < 1000; ++step) ASSERT_EQ(flows.health(1).value_or(wire::FlowHealth{}).matched, 7U);
  flows.add(2, std::make_unique<SlowWriter>(other), other_link.link());
  flows.remove(2);
  EXPECT_FALSE(flows.health(2).has_value());
  auto removal = std::async(std::launch::async, [&flows] { flows.remove(1); });
  while (flows.health(1)) std::this_thread::yield();
  EXPECT_EQ(removal.wait_for(20ms), std::future_status::timeout) << "a sample of the flow is being written";
  slow.may_return.set_value();
  EXPECT_TRUE(slow.returned_in_time.get_future().get());

  removal.get();
  for (Watched* each : {&slow, &other}) each->destroyed.get_future().get();
  EXPECT_EQ(other.writing.get_future().wait_for(0s), std::future_status::timeout)
      << "a removed flow moves no sample";
}

/// The numbers of the samples that a NotingWriter has written.
class Noted {
 public:
  void add(std::uint64_t number) {
    const std::lock_guard lock{mutex_};
    numbers_.push_back(number);
    changed_.notify_all();
  }
  /// Returns all numbers as soon as they include this one, or after a minute.
  std::vector<std::uint64_t> until(std::uint64_t number) {
    std::unique_lock lock{mutex_};
    changed_.wait_for(lock, 60s, [&] { return std::ranges::find(numbers_, number) != numbers_.end(); });
    return numbers_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::uint64_t> numbers_;
};

class NotingWriter final : public SampleWriter {
 public:
  explicit NotingWriter(Noted& noted) : noted_(noted) {}
  bool write(const Bytes&, std::int64_t, std::uint64_t number) override {
    noted_.add(number);
    return true;
  }
  [[nodiscard]] wire::FlowHealth health() const override { return {}; }

 private:
  Noted& noted_;
};

TEST(OutgoingFlows, WriteOnlyTheNewestSampleOfAThinnedFlowEachTime) {
  using Numbers = std::vector<std::uint64_t>;
  Full link;
  Full other_link;
  Noted noted;
  Noted other;
  channel::WakeWord wake_word{};
  OutgoingFlows flows{wake_word, 0};
  ASSERT_TRUE(flows.start().ok());
  flows.add(1, std::make_unique<NotingWriter>(noted), link.link());
  flows.add(2, std::make_unique<NotingWriter>(other), other_link.link());
  EXPECT_EQ(noted.until(1), (Numbers{1}));
  // When two samples of the other flow have passed, the thread has seen all that came before them.
  std::uint64_t last = 1;
  const auto let_it_pass = [&] {
    for (int i = 0; i < 2; ++i) {
      other_link.publish();
      ASSERT_EQ(other.until(++last).back(), last);
    }
  };
  flows.thin_out(1, 1h);
  let_it_pass();
  link.publish();
  EXPECT_EQ(noted.until(2), (Numbers{1, 2})) << "the first sample does not wait";

  for (int i = 0; i < 3; ++i) link.publish();
  let_it_pass();
  EXPECT_EQ(noted.until(2), (Numbers{1, 2})) << "the others wait for an hour";
  flows.thin_out(1, 1ns);
  EXPECT_EQ(noted.until(5), (Numbers{1, 2, 5}));
  flows.thin_out(1, 0ns);
  link.publish();
  link.publish();
  EXPECT_EQ(noted.until(7), (Numbers{1, 2, 5, 6, 7}));
}

}  // namespace
}  // namespace takt::dds::outgoing_flows_test
