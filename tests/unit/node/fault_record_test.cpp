#include <takt/node/fault_record.hpp>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <thread>

#include <long_enough.hpp>

namespace takt::node::fault_record_test {
namespace {

using model::Fault;
using model::FaultKind;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Fault event(const std::string& cause, FaultKind kind = FaultKind::overrun) {
  return {.time_ns = 1'700'000'000'000'000'123,
          .cell = "cell",
          .device = "robot",
          .module = "servo",
          .kind = kind,
          .error = "crash",
          .cause = cause,
          .attachment = "/tmp/core.1",
          .count = 3,
          .cycle = 1234};
}

std::vector<std::uint64_t> numbers(const std::vector<Fault>& events) {
  std::vector<std::uint64_t> numbers;
  for (const Fault& each : events) numbers.push_back(each.sequence);
  return numbers;
}

template <class Holds>
bool soon(Holds&& holds) {
  const auto end = std::chrono::steady_clock::now() + long_enough();
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return true;
}

/// Simulates a full disk by a limit on the size of the files that this process writes.
class ShortFiles {
 public:
  explicit ShortFiles(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{.rlim_cur = bytes, .rlim_max = before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~ShortFiles() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  ShortFiles(const ShortFiles&) = delete;
  ShortFiles& operator=(const ShortFiles&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

/// Makes the next process or thread that opens a file wait, until this object is destroyed.
class SlowToOpen {
 public:
  explicit SlowToOpen(const std::string& path)
      : handler_(std::signal(SIGIO, SIG_IGN)),
        fd_(::open(path.c_str(), O_RDWR | O_CLOEXEC)),
        works_(::fcntl(fd_, F_SETLEASE, F_WRLCK) == 0) {}
  ~SlowToOpen() {
    ::fcntl(fd_, F_SETLEASE, F_UNLCK);
    ::close(fd_);
    std::signal(SIGIO, handler_);
  }
  SlowToOpen(const SlowToOpen&) = delete;
  SlowToOpen& operator=(const SlowToOpen&) = delete;
  [[nodiscard]] bool works() const { return works_; }
  /// Waits until something opens the file.
  [[nodiscard]] bool is_opened_soon() const {
    return soon([this] { return ::fcntl(fd_, F_GETLEASE) != F_WRLCK; });
  }

 private:
  void (*handler_)(int);
  int fd_;
  bool works_;
};

class RecordOfFaults : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "/faults-" + testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    path_ = FaultRecord::path(folder_, "robot", 7);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static constexpr std::size_t kSlots = 4;
  FaultRecord open() { return FaultRecord::open(path_, kSlots); }
  void append(FaultRecord& record, int count) {
    for (int i = 0; i < count; ++i) {
      Fault fault = event("number " + std::to_string(++appended_));
      record.append(fault);
    }
  }
  /// Calls reopen() until the file is in use again.
  static bool reopened(FaultRecord& record) {
    return soon([&record] { return record.reopen(); });
  }
  std::string content() const {
    std::ifstream file{path_, std::ios::binary};
    return {std::istreambuf_iterator<char>{file}, {}};
  }
  void put(const std::string& content) const {
    std::ofstream{path_, std::ios::binary | std::ios::trunc} << content;
  }

  std::string folder_;
  std::string path_;
  int appended_ = 0;
};

TEST_F(RecordOfFaults, WritesAnEventToItsFile) {
  FaultRecord record = open();
  EXPECT_THAT(record.problems(), IsEmpty());
  EXPECT_EQ(record.file(), path_);
  Fault fault = event("run() threw");
  record.append(fault);
  EXPECT_EQ(fault.sequence, 1U);
  EXPECT_THAT(record.events(), ElementsAre(fault));
  const auto read = read_record_file(path_);
  ASSERT_TRUE(read.ok());
  EXPECT_THAT(read->events, ElementsAre(fault));
  EXPECT_EQ(read->damaged + read->overwritten, 0U);
}

TEST_F(RecordOfFaults, KeepsTheNewestEventsWhenItIsFull) {
  FaultRecord record = open();
  append(record, kSlots);
  EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(record.overwritten(), 0U);
  append(record, 1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 3, 4, 5));
  EXPECT_EQ(record.overwritten(), 1U);
  append(record, 9);
  EXPECT_EQ(record.overwritten(), 10U);
  const auto read = read_record_file(path_);
  ASSERT_TRUE(read.ok());
  EXPECT_THAT(read->events, testing::ElementsAreArray(record.events()));
  EXPECT_THAT(numbers(read->events), ElementsAre(11, 12, 13, 14));
  EXPECT_EQ(read->overwritten, 10U);
}

TEST_F(RecordOfFaults, ContinuesTheEventNumbersAfterARestart) {
  for (int restart = 0; restart < 4; ++restart) {
    FaultRecord record = open();
    append(record, 3);
    EXPECT_EQ(record.events().back().sequence, 3U * (static_cast<unsigned>(restart) + 1));
  }
  EXPECT_EQ(open().overwritten(), 8U);
}

TEST_F(RecordOfFaults, CreatesTheFileWithItsFullSize) {
  open();
  const std::string at_first = content();
  EXPECT_EQ(at_first.size(), 4096 + kSlots * kSlotBytes);
  FaultRecord record = open();
  append(record, 10);
  EXPECT_EQ(content().size(), at_first.size());
}

TEST_F(RecordOfFaults, RejectsASlotWithAnyDamagedByte) {
  Fault fault = event("run() threw");
  fault.sequence = 5;
  const std::string slot = encode_slot(fault);
  ASSERT_EQ(decode_slot(slot), fault);
  for (std::size_t i = 0; i < slot.size(); ++i) {
    for (const int change : {1, 0x80, 0xff}) {
      std::string damaged = slot;
      damaged[i] = static_cast<char>(damaged[i] ^ change);
      EXPECT_EQ(decode_slot(damaged), std::nullopt) << "byte " << i;
    }
  }
}

TEST_F(RecordOfFaults, IgnoresAnEventWithAForgedHugeNumber) {
  {
    FaultRecord record = open();
    append(record, 2);
  }
  Fault forged = event("it never was");
  forged.sequence = std::numeric_limits<std::uint64_t>::max();
  const std::streamoff at = 4096 + static_cast<std::streamoff>((forged.sequence - 1) % kSlots * kSlotBytes);
  std::fstream{path_, std::ios::in | std::ios::out | std::ios::binary}.seekp(at) << encode_slot(forged);
  FaultRecord record = open();
  EXPECT_EQ(record.damaged(), 1U);
  append(record, 2);
  EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2, 3, 4));
}

TEST_F(RecordOfFaults, KeepsOneEventOfEachNumber) {
  {
    FaultRecord record = open();
    append(record, 2);
  }
  Fault second = event("it has the number of another event");
  second.sequence = 1;
  std::fstream{path_, std::ios::in | std::ios::out | std::ios::binary}.seekp(4096 + 2 * kSlotBytes)
      << encode_slot(second);
  FaultRecord record = open();
  EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2));
  EXPECT_EQ(record.events().front().cause, "number 1");
  EXPECT_EQ(record.damaged(), 1U);
  append(record, 3);
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 3, 4, 5));
  EXPECT_EQ(read_record_file(path_)->events, record.events());
}

TEST_F(RecordOfFaults, KeepsTheOtherEventsIfNewerOnesAreMissing) {
  {
    FaultRecord record = open();
    append(record, 3);
  }
  Fault later = event("much later");
  later.sequence = 9;
  std::fstream{path_, std::ios::in | std::ios::out | std::ios::binary}.seekp(4096) << encode_slot(later);
  FaultRecord record = open();
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 3, 9));
  append(record, 2);
  EXPECT_THAT(numbers(record.events()), ElementsAre(3, 9, 10, 11));
  EXPECT_EQ(read_record_file(path_)->events, record.events());
}

TEST_F(RecordOfFaults, KeepsOtherEventsWhenAModuleLogsManyLines) {
  const auto log = [](FaultRecord& record, int lines) {
    for (int i = 0; i < lines; ++i) {
      Fault line = event("a line", FaultKind::log_info);
      record.append(line);
    }
  };
  {
    FaultRecord record = open();
    append(record, 2);
    log(record, 100);
    EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2, 101, 102));
    EXPECT_EQ(record.overwritten(), 98U);
  }
  FaultRecord record = open();
  EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2, 101, 102));
  append(record, 1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 101, 102, 103)) << "lines keep half of the slots, too";
  log(record, 1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 102, 103, 104));
  EXPECT_EQ(read_record_file(path_)->events, record.events());
}

TEST(FaultRecord, KeepsTheEventsOfUnacknowledgedAlarmsWhenItIsFull) {
  FaultRecord record{4};
  const auto add = [&record](int events) {
    for (int i = 0; i < events; ++i) {
      model::Fault fault{.kind = model::FaultKind::overrun};
      record.append(fault);
    }
  };
  add(2);
  record.keep({2});
  add(20);
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 20, 21, 22));
  record.keep({2, 20, 21, 22});
  add(1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(20, 21, 22, 23)) << "it takes new events in any case";
  record.keep({});
  add(1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(21, 22, 23, 24));
}

TEST_F(RecordOfFaults, UsesAllItsSlotsForLinesUntilOtherEventsNeedThem) {
  FaultRecord record = open();
  for (int i = 0; i < 5; ++i) {
    Fault line = event("a line", FaultKind::log_error);
    record.append(line);
  }
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 3, 4, 5));
  append(record, 1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(3, 4, 5, 6));
}

TEST_F(RecordOfFaults, KeepsTheNumbersOfUnwrittenEventsWhenLinesBetweenThemWereReplaced) {
  FaultRecord record = open();
  append(record, 2);
  {
    const ShortFiles limit{4096};
    for (int i = 0; i < 4; ++i) {
      Fault line = event("a line", FaultKind::log_info);
      record.append(line);
    }
  }
  EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2, 5, 6));
  EXPECT_TRUE(reopened(record));
  EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2, 5, 6));
  EXPECT_EQ(read_record_file(path_)->events, record.events());
  append(record, 1);
  EXPECT_EQ(record.events().back().sequence, 7U);
}

TEST_F(RecordOfFaults, LosesOnlyTheEventWhoseWriteWasInterrupted) {
  {
    FaultRecord record = open();
    append(record, 3);
  }
  const std::string before = content();
  Fault next = event("the fourth, in an empty slot");
  next.sequence = 4;
  Fault over = event("the fifth, in the slot of the first");
  over.sequence = 5;
  for (const Fault& torn : {next, over}) {
    const std::string slot = encode_slot(torn);
    const std::size_t at = 4096 + ((torn.sequence - 1) % kSlots) * kSlotBytes;
    const std::string old = before.substr(at, kSlotBytes);
    for (std::size_t cut = 0; cut <= slot.size(); ++cut) {
      std::string after = before;
      after.replace(at, cut, slot.substr(0, cut));
      const auto read = read_record(after);
      ASSERT_TRUE(read.ok());
      const std::string there = after.substr(at, kSlotBytes);
      if (there == slot) {
        EXPECT_EQ(numbers(read->events).back(), torn.sequence);
        EXPECT_EQ(read->damaged, 0U);
      } else if (there == old) {
        EXPECT_THAT(numbers(read->events), ElementsAre(1, 2, 3));
        EXPECT_EQ(read->damaged, 0U);
      } else {
        EXPECT_EQ(read->damaged, 1U) << cut;
        EXPECT_EQ(read->events.back().sequence, 3U);
      }
    }
  }
}

TEST_F(RecordOfFaults, DoesNotReuseTheNumberOfADamagedEvent) {
  {
    FaultRecord record = open();
    append(record, 2);
  }
  std::string torn = content();
  torn.replace(4096 + 2 * kSlotBytes, 100, std::string(100, 'x'));
  put(torn);
  FaultRecord record = open();
  EXPECT_EQ(record.damaged(), 1U);
  append(record, 1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(1, 2, 4));
}

TEST_F(RecordOfFaults, ReadsTheIntactEventsOfATruncatedFile) {
  {
    FaultRecord record = open();
    append(record, 4);
  }
  const std::string whole = content();
  for (std::size_t size = 24; size < whole.size(); size += size < 4200 ? 1 : 37) {
    const auto read = read_record(whole.substr(0, size));
    ASSERT_TRUE(read.ok()) << size;
    EXPECT_EQ(read->events.size(), size <= 4096 ? 0 : (size - 4096) / kSlotBytes) << size;
  }
  put(whole.substr(0, 4096 + kSlotBytes + 5));
  FaultRecord record = open();
  EXPECT_THAT(record.problems(), IsEmpty());
  append(record, 1);
  EXPECT_EQ(content().size(), whole.size());
}

TEST_F(RecordOfFaults, RenamesAFileOfAnotherVersion) {
  open();
  std::string other = content();
  other[0] = static_cast<char>(other[0] + 1);
  put(other);
  EXPECT_FALSE(read_record_file(path_).ok());
  FaultRecord record = open();
  ASSERT_EQ(record.problems().size(), 1U);
  EXPECT_THAT(to_text(record.problems()), HasSubstr(path_ + ".damaged"));
  EXPECT_EQ(record.file(), path_);
  append(record, 1);
  EXPECT_EQ(read_record_file(path_)->events.size(), 1U);
  EXPECT_TRUE(std::filesystem::exists(path_ + ".damaged"));
}

TEST_F(RecordOfFaults, RecordsInMemoryIfTheFileCannotBeOpened) {
  std::filesystem::create_directories(path_);  // the file cannot be created, because a folder has its name
  FaultRecord record = open();
  EXPECT_EQ(record.problems().size(), 1U);
  EXPECT_EQ(record.file(), "");
  append(record, 6);
  EXPECT_THAT(numbers(record.events()), ElementsAre(3, 4, 5, 6));
  FaultRecord in_memory{2};
  append(in_memory, 3);
  EXPECT_THAT(numbers(in_memory.events()), ElementsAre(2, 3));
}

TEST_F(RecordOfFaults, WritesTheEventsInMemoryOnceTheFileCanBeOpened) {
  std::ofstream{folder_} << "a file where a folder should be";
  FaultRecord record = open();
  append(record, 6);
  EXPECT_FALSE(record.reopen());
  std::filesystem::remove(folder_);
  EXPECT_TRUE(reopened(record));
  EXPECT_FALSE(record.reopen()) << "the file is already open";
  EXPECT_THAT(record.problems(), IsEmpty());
  EXPECT_EQ(record.file(), path_);
  EXPECT_THAT(numbers(read_record_file(path_)->events), ElementsAre(3, 4, 5, 6));
  append(record, 1);
  EXPECT_THAT(numbers(read_record_file(path_)->events), ElementsAre(4, 5, 6, 7));
  EXPECT_EQ(record.overwritten(), 3U);
}

TEST_F(RecordOfFaults, AppendsUnwrittenEventsOnceTheFileCanBeWrittenAgain) {
  FaultRecord record = open();
  append(record, 2);
  {
    const ShortFiles limit{4096};
    append(record, 1);
    EXPECT_EQ(record.file(), "");
    EXPECT_FALSE(record.reopen());
    append(record, 1);
  }
  const std::vector<Fault> all = record.events();
  EXPECT_THAT(numbers(read_record_file(path_)->events), ElementsAre(1, 2));
  EXPECT_TRUE(reopened(record));
  EXPECT_EQ(record.events(), all);
  EXPECT_EQ(read_record_file(path_)->events, all);
  append(record, 1);
  EXPECT_THAT(numbers(record.events()), ElementsAre(2, 3, 4, 5));
}

TEST_F(RecordOfFaults, DoesNotWaitUntilItsFileCanBeOpened) {
  auto other = std::make_unique<FaultRecord>(open());
  FaultRecord record = open();
  append(record, 1);
  other.reset();
  {
    const SlowToOpen slow{path_};
    if (!slow.works()) GTEST_SKIP() << "this file system has no leases";
    EXPECT_FALSE(record.reopen());
    ASSERT_TRUE(slow.is_opened_soon());
    EXPECT_FALSE(record.reopen()) << "the file is still being opened";
  }
  EXPECT_TRUE(reopened(record));
  EXPECT_EQ(read_record_file(path_)->events, record.events());
}

TEST_F(RecordOfFaults, RenumbersItsUnwrittenEventsToFollowThoseInTheFile) {
  auto first = std::make_unique<FaultRecord>(open());
  append(*first, 2);
  FaultRecord second = open();
  append(second, 1);
  EXPECT_THAT(numbers(second.events()), ElementsAre(1));
  first.reset();
  EXPECT_TRUE(reopened(second));
  EXPECT_THAT(numbers(second.events()), ElementsAre(1, 2, 3));
  EXPECT_EQ(second.events()[2].cause, "number 3");
  EXPECT_EQ(read_record_file(path_)->events, second.events());
}

TEST_F(RecordOfFaults, LeavesNoPartialFileOnAFullDisk) {
  const ShortFiles limit{4096 + kSlotBytes};
  FaultRecord record = open();
  EXPECT_EQ(record.problems().size(), 1U);
  EXPECT_EQ(content(), "");
}

TEST_F(RecordOfFaults, RejectsAFileThatAnotherRecordHasOpen) {
  FaultRecord first = open();
  FaultRecord second = open();
  EXPECT_THAT(to_text(second.problems()), HasSubstr("in use"));
  append(first, 1);
  append(second, 1);
  EXPECT_EQ(read_record_file(path_)->events.size(), 1U);
}

TEST_F(RecordOfFaults, ShortensACauseThatIsTooLong) {
  FaultRecord record = open();
  Fault fault = event(std::string(2000, 'x'));
  record.append(fault);
  EXPECT_EQ(record.events()[0].cause, std::string(508, 'x') + "...");
  EXPECT_EQ(read_record_file(path_)->events, record.events());
}

TEST(ReadRecord, RejectsContentThatIsNotAFaultRecord) {
  for (const std::string& content : {std::string{}, std::string(10, 'x'), std::string(5000, '\0')})
    EXPECT_FALSE(read_record(content).ok());
  EXPECT_THAT(to_text(read_record_file("/nowhere/robot.0.faults").problems()),
              HasSubstr("/nowhere/robot.0.faults: error: there is no such file"));
}

}  // namespace
}  // namespace takt::node::fault_record_test
