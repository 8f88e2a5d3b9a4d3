#include <takt/channel/link.hpp>

#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <new>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include <full_form.hpp>
#include <long_enough.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel::link_test {
namespace {

/// A link in its own shared memory.
class Memory {
 public:
  explicit Memory(const Link::Options& options)
      : memory_(std::move(os::SharedMemory::create("takt-link", Link::layout(options).size()).value())) {
    Link::format(memory_.data(), options);
  }
  [[nodiscard]] Link link() const { return Link{memory_.data()}; }
  [[nodiscard]] std::byte* data() const { return memory_.data(); }
  [[nodiscard]] std::size_t size() const { return memory_.size(); }

 private:
  os::SharedMemory memory_;
};

Link::Options queue(std::uint32_t depth, std::uint32_t payload = 64) {
  return {.depth = depth, .payload = payload, .is_queue = depth > 1};
}

/// Writes one sample. Every word of the sample is the sample's sequence number.
void write(LinkWriter& writer, std::int64_t stamp_ns = 1) {
  const std::uint64_t value = writer.next();
  const std::uint32_t words = writer.link().stride() / 8;
  auto* payload = writer.link().payload(writer.buffer());
  for (std::uint32_t i = 0; i < words; ++i) std::memcpy(payload + std::size_t{i} * 8, &value, 8);
  writer.publish(words * 8, stamp_ns);
}
void write(LinkWriter& writer, int samples) {
  for (int i = 0; i < samples; ++i) write(writer);
}
/// Returns the number in the sample that the reader holds. Returns 0 if the sample is torn, or if its number
/// differs from the sequence number in its info.
std::uint64_t value_of(const LinkReader& reader) {
  const std::uint32_t words = reader.link().stride() / 8;
  const std::byte* payload = reader.link().payload(reader.buffer());
  for (std::uint32_t i = 0; i < words; ++i) {
    std::uint64_t value = 0;
    std::memcpy(&value, payload + std::size_t{i} * 8, 8);
    if (value != reader.info().sequence) return 0;
  }
  return reader.info().size == words * 8 ? reader.info().sequence : 0;
}
std::vector<std::uint64_t> read_all(LinkReader& reader) {
  std::vector<std::uint64_t> values;
  while (reader.take()) values.push_back(value_of(reader));
  return values;
}
/// Returns true if every buffer has exactly one owner: a slot, the writer or the reader.
bool is_whole(const LinkWriter& writer, const LinkReader& reader) {
  const Link link = writer.link();
  std::set<std::uint32_t> owned{writer.buffer(), reader.buffer()};
  for (std::uint32_t i = 0; i < link.depth(); ++i) owned.insert(SlotWord::index(link.slot(i).load()));
  return owned.size() == link.buffers() && *owned.rbegin() == link.buffers() - 1;
}

TEST(Link, IsEmptyBeforeTheFirstSample) {
  for (const std::uint32_t depth : {1U, 2U, 7U}) {
    const Memory memory{queue(depth)};
    LinkReader reader{memory.link()};
    EXPECT_FALSE(reader.has_news());
    EXPECT_FALSE(reader.take());
    EXPECT_EQ(reader.info().sequence, 0U);
  }
}

TEST(Link, DeliversEachSampleOnceAndInOrder) {
  for (const std::uint32_t depth : {1U, 2U, 7U}) {
    const Memory memory{queue(depth)};
    LinkWriter writer{memory.link()};
    LinkReader reader{memory.link()};
    for (std::uint64_t i = 1; i < 30; ++i) {
      write(writer, static_cast<std::int64_t>(100 * i));
      EXPECT_TRUE(reader.has_news());
      ASSERT_TRUE(reader.take());
      EXPECT_EQ(value_of(reader), i);
      EXPECT_EQ(reader.info().stamp_ns, static_cast<std::int64_t>(100 * i));
      EXPECT_FALSE(reader.has_news());
      EXPECT_FALSE(reader.take());
      EXPECT_EQ(value_of(reader), i) << "the sample stays until the next one";
    }
    EXPECT_EQ(memory.link().block().overwritten.load(), 0U);
    EXPECT_EQ(memory.link().block().taken.load(), 29U);
    EXPECT_EQ(memory.link().block().written.load(), 29U);
  }
}

TEST(Link, DropsAndCountsTheOldestSamplesOfAFullQueue) {
  const Memory memory{queue(7)};
  LinkWriter writer{memory.link()};
  LinkReader reader{memory.link()};
  write(writer, 7);
  EXPECT_EQ(memory.link().block().overwritten.load(), 0U) << "7 samples fit";
  write(writer, 3);
  EXPECT_EQ(memory.link().block().overwritten.load(), 3U);
  EXPECT_EQ(read_all(reader), (std::vector<std::uint64_t>{4, 5, 6, 7, 8, 9, 10}));
  write(writer, 1000);
  EXPECT_EQ(memory.link().block().overwritten.load(), 996U);
  EXPECT_EQ(read_all(reader), (std::vector<std::uint64_t>{1004, 1005, 1006, 1007, 1008, 1009, 1010}));
}

TEST(Link, SkipsSamplesOverwrittenBeforeTheyWereRead) {
  const Memory memory{queue(3)};
  LinkWriter writer{memory.link()};
  LinkReader reader{memory.link()};
  write(writer, 3);
  ASSERT_TRUE(reader.take());
  EXPECT_EQ(value_of(reader), 1U);
  write(writer, 2);  // sample 4 takes the slot of sample 1, and sample 5 overwrites sample 2
  EXPECT_EQ(memory.link().block().overwritten.load(), 1U);
  EXPECT_EQ(read_all(reader), (std::vector<std::uint64_t>{3, 4, 5}));
}

TEST(Link, HoldsOnlyTheLatestValueAtDepthOne) {
  const Memory memory{queue(1)};
  LinkWriter writer{memory.link()};
  LinkReader reader{memory.link()};
  write(writer, 50);
  EXPECT_EQ(read_all(reader), std::vector<std::uint64_t>{50});
  write(writer, 1);
  EXPECT_EQ(read_all(reader), std::vector<std::uint64_t>{51});
}

TEST(Link, ShowsTheTimeOfTheNewestSampleBeforeItIsRead) {
  const Memory memory{queue(2)};
  LinkWriter writer{memory.link()};
  EXPECT_EQ(memory.link().block().newest_ns.load(), 0);
  write(writer, std::int64_t{1234});
  EXPECT_EQ(memory.link().block().newest_ns.load(), 1234);
}

TEST(Link, LetsANewWriterOrReaderContinueWhereTheOldOneStopped) {
  for (const std::uint32_t depth : {1U, 2U, 7U}) {
    const Memory memory{queue(depth)};
    std::uint64_t read = 0;
    for (int life = 0; life < 20; ++life) {
      LinkWriter writer{memory.link()};
      write(writer, life % 3);
      LinkReader reader{memory.link()};
      EXPECT_TRUE(is_whole(writer, reader));
      for (const std::uint64_t value : read_all(reader)) {
        EXPECT_GT(value, read);
        read = value;
      }
      write(writer, 1);
    }
    LinkReader reader{memory.link()};
    ASSERT_FALSE(read_all(reader).empty());
    EXPECT_EQ(value_of(reader), memory.link().block().written.load()) << "depth " << depth;
  }
}

TEST(Link, CanBeUsedAgainAfterItsSamplesWereDropped) {
  for (const std::uint32_t depth : {1U, 2U, 7U}) {
    for (int unread = 0; unread < 20; ++unread) {
      const Memory memory{queue(depth)};
      {
        LinkWriter writer{memory.link()};
        LinkReader reader{memory.link()};
        write(writer, 5);
        reader.take();
        write(writer, unread);
      }
      drop_samples(memory.link());
      LinkReader reader{memory.link()};
      LinkWriter writer{memory.link()};
      EXPECT_TRUE(is_whole(writer, reader));
      EXPECT_FALSE(reader.has_news());
      EXPECT_FALSE(reader.take());
      EXPECT_EQ(memory.link().block().newest_ns.load(), 0);
      write(writer, 2);
      const auto next = static_cast<std::uint64_t>(unread) + 6;
      EXPECT_EQ(read_all(reader), depth == 1 ? std::vector<std::uint64_t>{next + 1}
                                             : (std::vector<std::uint64_t>{next, next + 1}));
    }
  }
}

TEST(Link, RejectsMemoryThatIsNotALink) {
  const Memory memory{queue(7)};
  EXPECT_TRUE(Link::is_link(memory.data(), memory.size()));
  EXPECT_FALSE(Link::is_link(memory.data(), memory.size() - 1));
  EXPECT_FALSE(Link::is_link(memory.data(), 10));
  memory.link().block().depth = 0;
  EXPECT_FALSE(Link::is_link(memory.data(), memory.size()));
  memory.link().block().depth = 0xffff'ffff;
  EXPECT_FALSE(Link::is_link(memory.data(), memory.size()));
  memory.link().block().depth = 7;
  ++memory.link().block().magic;
  EXPECT_FALSE(Link::is_link(memory.data(), memory.size()));
}

TEST(Link, HoldsAsManySamplesAsTheMaximumDepth) {
  const Memory memory{queue(kMaxLinkDepth, 8)};
  LinkWriter writer{memory.link()};
  LinkReader reader{memory.link()};
  write(writer, static_cast<int>(kMaxLinkDepth) + 5);
  std::uint64_t expected = 6;
  while (reader.take()) ASSERT_EQ(value_of(reader), expected++);
  EXPECT_EQ(expected, kMaxLinkDepth + 6);
  EXPECT_TRUE(is_whole(writer, reader));
}

TEST(Link, StaysWithinItsMemoryEvenIfItIsCorrupted) {
  std::mt19937_64 random{7};
  for (int round = 0; round < 2000; ++round) {
    const Memory memory{queue(3)};
    LinkWriter writer{memory.link()};
    LinkReader reader{memory.link()};
    write(writer, 2);
    for (int i = 0; i < 3; ++i) {
      const std::size_t place = random() % (memory.size() / 8);
      const std::uint64_t word = random() % 2 == 0 ? random() : random() % (1U << 20);
      std::memcpy(memory.data() + place * 8, &word, 8);
    }
    for (int i = 0; i < 5; ++i) {
      reader.take();
      EXPECT_LT(reader.buffer(), 5U);
      write(writer, 1);
      EXPECT_LT(writer.buffer(), 5U);
      EXPECT_LE(reader.info().size, 64U);
    }
    if (!Link::is_link(memory.data(), memory.size())) continue;  // Takt never attaches such memory
    EXPECT_LT(LinkReader{memory.link()}.buffer(), memory.link().buffers());
    EXPECT_LT(LinkWriter{memory.link()}.buffer(), memory.link().buffers());
  }
}

// ---- Two threads -----------------------------------------------------------------------------------------

void stress(std::uint32_t depth, bool slow_reader, bool slow_writer) {
  const Memory memory{queue(depth, 256)};
  const Instant end = os::now() + std::chrono::milliseconds{full_form() ? 1500 : 300};
  std::atomic<bool> over{false};
  std::thread thread{[&] {
    LinkWriter writer{memory.link()};
    while (os::now() < end) {
      write(writer, slow_writer ? 1 : 50);
      if (slow_writer) ::sched_yield();
    }
    over = true;
  }};
  LinkReader reader{memory.link()};
  std::uint64_t last = 0;
  std::uint64_t read = 0;
  std::uint64_t gaps = 0;
  while (true) {
    const bool last_look = over;
    if (reader.take()) {
      const std::uint64_t value = value_of(reader);
      ASSERT_NE(value, 0U) << "a torn sample after " << last;
      ASSERT_GT(value, last);
      gaps += value - last - 1;
      last = value;
      ++read;
      if (slow_reader) ::sched_yield();
    } else if (last_look) {
      break;
    }
  }
  thread.join();
  const LinkBlock& block = memory.link().block();
  EXPECT_EQ(last, block.written.load()) << "the newest sample is never lost";
  EXPECT_EQ(read, block.taken.load());
  EXPECT_EQ(gaps, block.overwritten.load());
  EXPECT_TRUE(is_whole(LinkWriter{memory.link()}, reader));
  testing::Test::RecordProperty("read", static_cast<int>(read));
}

TEST(LinkBetweenTwoThreads, DeliversEachSampleIntactOrCountsItAsLost) {
  for (const std::uint32_t depth : {1U, 2U, 7U}) {
    SCOPED_TRACE(depth);
    stress(depth, false, false);
    stress(depth, true, false);
    stress(depth, false, true);
  }
}

// ---- Two processes, one of which the test kills repeatedly -----------------------------------------------

class Killed {
 public:
  template <class Work>
  explicit Killed(const Work& work) : pid_(::fork()) {
    if (pid_ != 0) return;
    work();
    ::_exit(0);
  }
  ~Killed() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }

 private:
  int pid_;
};

void sleep_us(std::uint64_t us) { os::sleep_until(os::now() + std::chrono::microseconds{us}); }

constexpr int kKills = kSanitized ? 100 : 1500;

struct Shared {
  std::atomic<std::uint64_t> torn;
  std::atomic<std::uint64_t> not_in_order;
  std::atomic<std::uint64_t> last;
  std::atomic<std::uint64_t> read;
};

void read_for_ever(Link link, Shared& shared) {
  LinkReader reader{link};
  while (true) {
    if (!reader.take()) continue;
    const std::uint64_t value = value_of(reader);
    if (value == 0) ++shared.torn;
    if (value <= shared.last) ++shared.not_in_order;
    shared.last = value;
    ++shared.read;
  }
}

void write_for_ever(Link link) {
  LinkWriter writer{link};
  while (true) write(writer, 1);
}

class LinkBetweenTwoProcesses : public testing::TestWithParam<std::uint32_t> {
 protected:
  LinkBetweenTwoProcesses()
      : memory(queue(GetParam(), 128)),
        counters(std::move(os::SharedMemory::create("takt-test", sizeof(Shared)).value())),
        shared(*new (counters.data()) Shared{}) {}

  /// Waits until another sample arrives. Returns false if none arrives.
  bool another_sample_arrives() {
    const std::uint64_t before = shared.read;
    const Instant end = os::now() + long_enough();
    while (shared.read == before) {
      if (os::now() > end) return false;
      sleep_us(50);
    }
    return true;
  }

  template <class Work>
  void kill_again_and_again(const Work& work) {
    for (int i = 0; i < kKills; ++i) {
      const Killed side{work};
      sleep_us(random() % 300);
      // On a slow machine, the process may not have begun its work yet. So some of the processes are killed
      // after they have done some.
      if (i % 10 == 9) {
        ASSERT_TRUE(another_sample_arrives()) << "after " << i << " kills";
      }
    }
  }

  void check_the_end() {
    EXPECT_EQ(shared.torn, 0U);
    EXPECT_EQ(shared.not_in_order, 0U);
    EXPECT_GT(shared.read, 0U);
    LinkWriter writer{memory.link()};
    LinkReader reader{memory.link()};
    EXPECT_TRUE(is_whole(writer, reader));
    read_all(reader);
    write(writer, 1);
    ASSERT_TRUE(reader.take());
    EXPECT_EQ(value_of(reader), memory.link().block().written.load());
  }

  const Memory memory;
  os::SharedMemory counters;
  Shared& shared;
  std::mt19937 random{GetParam()};
};

TEST_P(LinkBetweenTwoProcesses, SurvivesKilledWriters) {
  {
    const Killed reader{[&] { read_for_ever(memory.link(), shared); }};
    kill_again_and_again([&] { write_for_ever(memory.link()); });
  }
  check_the_end();
}

TEST_P(LinkBetweenTwoProcesses, SurvivesKilledReaders) {
  {
    const Killed writer{[&] { write_for_ever(memory.link()); }};
    kill_again_and_again([&] { read_for_ever(memory.link(), shared); });
  }
  check_the_end();
}

TEST_P(LinkBetweenTwoProcesses, SurvivesKilledWritersAndReaders) {
  for (int i = 0; i < kKills / 2; ++i) {
    const Killed writer{[&] { write_for_ever(memory.link()); }};
    const Killed reader{[&] { read_for_ever(memory.link(), shared); }};
    if (i % 10 == 9) {
      ASSERT_TRUE(another_sample_arrives()) << "after " << i << " kills of both";
    }
    sleep_us(random() % 600);
  }
  check_the_end();
}

INSTANTIATE_TEST_SUITE_P(Depths, LinkBetweenTwoProcesses, testing::Values(1, 2, 7),
                         [](const auto& depth) { return "Depth" + std::to_string(depth.param); });

}  // namespace
}  // namespace takt::channel::link_test
