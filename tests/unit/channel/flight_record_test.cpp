#include <takt/channel/flight_record.hpp>

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <thread>

namespace takt::channel::flight_record_test {
namespace {

constexpr std::uint64_t kCapacity = 16;

void add(FlightWriter& writer, std::uint64_t n) {
  writer.add(FlightKind::run, static_cast<std::int64_t>(1000 + n), static_cast<std::uint32_t>(n % 7),
             static_cast<std::int64_t>(n));
}

TEST(FlightRecord, IsEmptyBeforeTheFirstEntry) {
  const auto record = FlightRecord::create({kCapacity, 0});
  ASSERT_TRUE(record.ok());
  for (const std::size_t ring : {0U, 1U}) {
    const FlightCopy copy = record->copy(ring);
    EXPECT_TRUE(copy.entries.empty());
    EXPECT_EQ(copy.written, 0U);
    EXPECT_EQ(copy.lost, 0U);
  }
}

TEST(FlightRecord, ReadsBackAnEntryUnchanged) {
  const auto record = FlightRecord::create({kCapacity});
  FlightWriter writer = record->writer(0);
  writer.add(FlightKind::row, 12'345'678'901, 0, 2'000'000'000'000 / 2);
  writer.add(FlightKind::write, -5, 1'000'000, 7);
  const FlightCopy copy = record->copy(0);
  ASSERT_EQ(copy.entries.size(), 2U);
  EXPECT_EQ(copy.entries[0], (FlightSample{12'345'678'901, FlightKind::row, 0, 1'000'000'000'000}));
  EXPECT_EQ(copy.entries[1], (FlightSample{-5, FlightKind::write, 1'000'000, 7}));
}

TEST(FlightRecord, ClampsValuesToTheirBounds) {
  const auto record = FlightRecord::create({kCapacity});
  FlightWriter writer = record->writer(0);
  writer.add(FlightKind::run, 1, 0xffff'ffff, std::int64_t{1} << 62);
  writer.add(FlightKind::run, 2, 3, -1);
  const FlightCopy copy = record->copy(0);
  EXPECT_EQ(copy.entries[0],
            (FlightSample{1, FlightKind::run, FlightWriter::kMostModule, FlightWriter::kMostValue}));
  EXPECT_EQ(copy.entries[1], (FlightSample{2, FlightKind::run, 3, 0}));
}

// A copy of a full ring omits the oldest entry, because the writer may be overwriting this entry.
TEST(FlightRecord, HoldsTheNewestEntriesWhenItIsFull) {
  for (std::uint64_t n = 0; n <= 5 * kCapacity; ++n) {
    const auto record = FlightRecord::create({kCapacity});
    FlightWriter writer = record->writer(0);
    for (std::uint64_t i = 0; i < n; ++i) add(writer, i);
    const FlightCopy copy = record->copy(0);
    const std::uint64_t held = n < kCapacity ? n : kCapacity - 1;
    ASSERT_EQ(copy.entries.size(), held) << n;
    EXPECT_EQ(copy.written, n);
    EXPECT_EQ(copy.lost, 0U);
    for (std::uint64_t i = 0; i < held; ++i) EXPECT_EQ(copy.entries[i].value, n - held + i);
  }
}

TEST(FlightRecord, ContinuesWhenAnotherWriterTakesOver) {
  const auto record = FlightRecord::create({kCapacity});
  {
    FlightWriter first = record->writer(0);
    add(first, 0);
  }
  const auto theirs = FlightRecord::attach(os::Fd{::dup(record->fd().get())});
  ASSERT_TRUE(theirs.ok());
  FlightWriter second = theirs->writer(0);
  add(second, 1);
  const FlightCopy copy = record->copy(0);
  ASSERT_EQ(copy.entries.size(), 2U);
  EXPECT_EQ(copy.entries[1].value, 1U);
}

TEST(FlightRecord, KeepsEntriesOfDifferentRingsApart) {
  const auto record = FlightRecord::create({2, 0, 4});
  FlightWriter first = record->writer(0);
  FlightWriter none = record->writer(1);
  FlightWriter past = record->writer(3);
  FlightWriter third = record->writer(2);
  for (std::uint64_t i = 0; i < 100; ++i) {
    add(first, i);
    add(none, i);
    add(past, i);
  }
  add(third, 7);
  EXPECT_EQ(record->copy(0).entries.size(), 1U);
  EXPECT_EQ(record->copy(0).entries[0].value, 99U);
  EXPECT_EQ(record->copy(1).entries.size(), 0U);
  ASSERT_EQ(record->copy(2).entries.size(), 1U);
  EXPECT_EQ(record->copy(2).entries[0].value, 7U);
}

TEST(FlightRecord, RejectsMemoryWithAnotherLayout) {
  const auto rejected = [](std::size_t offset, std::uint64_t value) {
    const auto record = FlightRecord::create({kCapacity, kCapacity});
    auto memory = os::SharedMemory::attach(os::Fd{::dup(record->fd().get())});
    std::memcpy(memory->data() + offset, &value, sizeof value);
    return !FlightRecord::attach(os::Fd{::dup(record->fd().get())}).ok();
  };
  EXPECT_TRUE(rejected(0, 1));  // byte 0 belongs to the magic number
  EXPECT_TRUE(rejected(8, 3));  // byte 8 belongs to the number of rings
  EXPECT_TRUE(rejected(8, ~std::uint64_t{0}));
  EXPECT_TRUE(rejected(64, kCapacity * 2));  // byte 64 belongs to the capacity of a ring
  EXPECT_TRUE(rejected(64, kCapacity - 1));
  EXPECT_TRUE(rejected(64, std::uint64_t{1} << 63));
}

TEST(FlightWriter, DoesNothingWithoutARing) {
  FlightWriter writer;
  add(writer, 1);
}

// A reader copies the record while a thread writes it. Every copy must contain complete, consecutive entries.
TEST(FlightRecord, CanBeReadWhileItIsWritten) {
  const auto record = FlightRecord::create({64});
  std::atomic<bool> end{false};
  std::thread thread{[&] {
    FlightWriter writer = record->writer(0);
    for (std::uint64_t i = 0; !end.load(std::memory_order_relaxed); ++i) add(writer, i);
  }};
  std::uint64_t read = 0;
  std::uint64_t lost = 0;
  for (int turn = 0; turn < 20'000 || read == 0; ++turn) {
    const FlightCopy copy = record->copy(0);
    for (std::size_t i = 0; i < copy.entries.size(); ++i) {
      const FlightSample& entry = copy.entries[i];
      ASSERT_EQ(entry.value, copy.entries[0].value + i);
      ASSERT_EQ(entry.time_ns, static_cast<std::int64_t>(1000 + entry.value));
      ASSERT_EQ(entry.module, entry.value % 7);
    }
    ASSERT_LE(copy.entries.size() + copy.lost, 64U);
    read += copy.entries.size();
    lost += copy.lost;
  }
  end = true;
  thread.join();
  RecordProperty("read", static_cast<int>(read % 1'000'000));
  RecordProperty("lost", static_cast<int>(lost % 1'000'000));
}

}  // namespace
}  // namespace takt::channel::flight_record_test
