#include <takt/recording/writer.hpp>

#include <sys/fsuid.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/core/cdr.hpp>
#include <takt/os/environment.hpp>

#include <takt/recording/database.hpp>
#include <takt/recording/reader.hpp>

namespace takt::recording::writer_test {
namespace {

using testing::HasSubstr;

/// Returns a port whose type is struct Number { double value; }.
RecordedPort number_port(const std::string& path = "d.m.p", const std::string& type = "basic::Number") {
  return {path, "takt/c/" + path, false, {type, {{.name = "value", .scalar = model::Scalar::float64}}}};
}

std::vector<std::byte> number(double value) {
  std::vector<std::byte> bytes(12);
  CdrWriter to{bytes.data(), bytes.size()};
  to.put(value);
  return bytes;
}

class RecordingFile : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path{testing::TempDir()} /
              ("takt-recording-" + std::string{test->name()} + std::to_string(::takt::os::process_id()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] std::string file(const std::string& name = "a.takt") const { return folder_ / name; }

  static void add(RecordingWriter& writer, std::int64_t port, std::int64_t time_ns, double value) {
    const auto bytes = number(value);
    writer.add(port, time_ns, bytes.data(), bytes.size());
  }
  /// Waits until the writer has written or lost all `samples` samples, or until the file is full.
  static void settle(const RecordingWriter& writer, std::uint64_t samples) {
    while (writer.health().samples + writer.health().lost < samples && !writer.health().full)
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  static std::vector<RecordedSample> all(Recording& recording, std::vector<double>* values = nullptr) {
    std::vector<RecordedSample> samples;
    std::uint64_t wrong = 0;
    const auto done = recording.read(
        {},
        [&](const RecordedSample& sample) {
          samples.push_back(sample);
          if (values != nullptr) values->push_back(CdrReader{sample.bytes, sample.size}.get<double>());
          return true;
        },
        wrong);
    EXPECT_TRUE(done);
    EXPECT_EQ(0U, wrong);
    return samples;
  }
  std::uintmax_t on_disk() const {
    std::uintmax_t bytes = 0;
    for (const auto& entry : std::filesystem::directory_iterator{folder_}) {
      // The index of SQLite's write-ahead log does not count, because it is shared memory that always has 32
      // kB.
      if (entry.path().extension() != ".takt-shm") bytes += entry.file_size();
    }
    return bytes;
  }
  std::filesystem::path folder_;
};

RecordingOptions quick(const std::string& file) {
  RecordingOptions options;
  options.file = file;
  options.flush = std::chrono::milliseconds{1};
  return options;
}

TEST_F(RecordingFile, IsNeverAPipeOrDevice) {
  ASSERT_EQ(0, ::mkfifo(file().c_str(), 0600));
  for (const bool append : {false, true}) {
    RecordingOptions options = quick(file());
    options.append = append;
    const auto writer = RecordingWriter::create(options);
    ASSERT_FALSE(writer.ok());
    EXPECT_EQ(to_text(writer.problems()),
              file() + ": error: is not a regular file; record into another file");
  }
  EXPECT_EQ(1, std::distance(std::filesystem::directory_iterator{folder_}, {})) << "no journal beside it";
}

TEST_F(RecordingFile, KeepsSamplesInOrder) {
  auto writer = RecordingWriter::create(quick(file()));
  ASSERT_TRUE(writer) << to_text(writer.problems());
  const auto one = (*writer)->add_port(number_port("d.m.one"), "cell");
  const auto two = (*writer)->add_port(number_port("d.m.two"), "cell");
  EXPECT_NE(one, two);
  EXPECT_EQ(one, (*writer)->add_port(number_port("d.m.one"), "cell"));
  for (int i = 0; i < 1000; ++i) add(**writer, i % 2 == 0 ? one : two, 1000 + i, i);
  ASSERT_TRUE((*writer)->finish());
  EXPECT_EQ(1000U, (*writer)->health().samples);
  EXPECT_EQ(0U, (*writer)->health().lost);
  EXPECT_FALSE(std::filesystem::exists(file() + "-wal"));

  auto recording = Recording::open(file());
  ASSERT_TRUE(recording) << to_text(recording.problems());
  EXPECT_EQ("cell", recording->cell());
  ASSERT_EQ(2U, recording->ports().size());
  EXPECT_EQ("d.m.one", recording->ports()[0].path);
  EXPECT_EQ(number_port().type, recording->ports()[0].type);
  EXPECT_EQ(500U, recording->ports()[1].samples);
  EXPECT_EQ(1000, recording->first_ns());
  EXPECT_EQ(1999, recording->last_ns());
  std::vector<double> values;
  all(*recording, &values);
  ASSERT_EQ(1000U, values.size());
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(i, values[static_cast<std::size_t>(i)]);
}

TEST_F(RecordingFile, IsExtendedOnlyWithTheAppendOption) {
  {
    auto writer = RecordingWriter::create(quick(file()));
    ASSERT_TRUE(writer);
    add(**writer, (*writer)->add_port(number_port()), 1, 1);
  }
  const auto refused = RecordingWriter::create(quick(file()));
  ASSERT_FALSE(refused);
  EXPECT_THAT(to_text(refused.problems()), HasSubstr("exists already"));

  auto options = quick(file());
  options.append = true;
  {
    auto writer = RecordingWriter::create(options);
    ASSERT_TRUE(writer) << to_text(writer.problems());
    add(**writer, (*writer)->add_port(number_port()), 2, 2);
    // A port with the same name but a different type counts as a second port.
    add(**writer, (*writer)->add_port(number_port("d.m.p", "basic::Other")), 3, 3);
  }
  auto recording = Recording::open(file());
  ASSERT_TRUE(recording);
  ASSERT_EQ(2U, recording->ports().size());
  EXPECT_EQ(2U, recording->ports()[0].samples);
  EXPECT_EQ("basic::Other", recording->ports()[1].type.name);
}

TEST_F(RecordingFile, AcceptsSamplesAppendedToAnEmptyFile) {
  std::ofstream{file()}.flush();
  auto options = quick(file());
  options.append = true;
  {
    auto writer = RecordingWriter::create(options);
    ASSERT_TRUE(writer) << to_text(writer.problems());
    add(**writer, (*writer)->add_port(number_port()), 1, 1);
  }
  auto recording = Recording::open(file());
  ASSERT_TRUE(recording) << to_text(recording.problems());
  EXPECT_EQ(1U, recording->samples());
}

TEST_F(RecordingFile, IsRejectedIfItIsNotARecording) {
  std::ofstream{file()} << "this is a text of some length, and no database of any kind at all; long enough";
  auto options = quick(file());
  options.append = true;
  EXPECT_THAT(to_text(RecordingWriter::create(options).problems()), HasSubstr("is not a recording"));
  EXPECT_THAT(to_text(Recording::open(file()).problems()), HasSubstr("is not a recording"));
  EXPECT_THAT(to_text(Recording::open(file("none.takt")).problems()), HasSubstr("does not exist"));
  EXPECT_THAT(to_text(RecordingWriter::create(quick(file("no/folder.takt"))).problems()),
              HasSubstr("/no does not exist; create it, or choose another file"));
  options.max_bytes = 1000;
  EXPECT_THAT(to_text(RecordingWriter::create(options).problems()), HasSubstr("use at least 1 MB"));
}

TEST_F(RecordingFile, StopsAtItsSizeLimit) {
  auto options = quick(file());
  options.max_bytes = kLeastRecording;
  auto writer = RecordingWriter::create(options);
  ASSERT_TRUE(writer) << to_text(writer.problems());
  const auto port = (*writer)->add_port(number_port());
  for (int i = 0; !(*writer)->health().full && i < 1'000'000; ++i) {
    add(**writer, port, i, i);
    if (i % 1000 == 999) settle(**writer, static_cast<std::uint64_t>(i + 1));
    ASSERT_LE(on_disk(), kLeastRecording);
  }
  EXPECT_TRUE((*writer)->health().full);
  ASSERT_TRUE((*writer)->finish());
  EXPECT_LE(on_disk(), kLeastRecording);
  EXPECT_GT(on_disk(), kLeastRecording / 2);
  EXPECT_EQ(0U, (*writer)->health().dropped);

  auto recording = Recording::open(file());
  ASSERT_TRUE(recording);
  std::vector<double> values;
  all(*recording, &values);
  EXPECT_EQ((*writer)->health().samples, values.size());
  EXPECT_EQ(0, values.front());
  EXPECT_EQ(static_cast<double>(values.size() - 1), values.back());
}

TEST_F(RecordingFile, DropsTheOldestSamplesAtItsSizeLimit) {
  constexpr int kSamples = 200'000;  // several times as many as fit into the file
  auto options = quick(file());
  options.max_bytes = kLeastRecording;
  options.full = Full::oldest;
  auto writer = RecordingWriter::create(options);
  ASSERT_TRUE(writer) << to_text(writer.problems());
  const auto port = (*writer)->add_port(number_port());
  std::uintmax_t most = 0;
  for (int i = 0; i < kSamples; ++i) {
    add(**writer, port, i, i);
    if (i % 1000 != 999) continue;
    settle(**writer, static_cast<std::uint64_t>(i + 1));
    most = std::max(most, on_disk());
  }
  ASSERT_TRUE((*writer)->finish());
  EXPECT_LE(most, kLeastRecording);
  const RecordingHealth health = (*writer)->health();
  EXPECT_EQ(static_cast<std::uint64_t>(kSamples), health.samples);
  EXPECT_EQ(0U, health.lost);

  auto recording = Recording::open(file());
  ASSERT_TRUE(recording);
  std::vector<double> values;
  all(*recording, &values);
  ASSERT_FALSE(values.empty());
  EXPECT_EQ(health.samples - health.dropped, values.size());
  EXPECT_EQ(kSamples - 1, values.back());
  EXPECT_EQ(static_cast<double>(kSamples) - static_cast<double>(values.size()), values.front());
  // The samples that remain must fill a third of the size limit, at 30 bytes each.
  EXPECT_GT(values.size() * 30, kLeastRecording / 3);
}

TEST_F(RecordingFile, ShrinksToASmallerSizeLimit) {
  {
    auto writer = RecordingWriter::create(quick(file()));
    ASSERT_TRUE(writer);
    const auto port = (*writer)->add_port(number_port());
    for (int i = 0; i < 100'000; ++i) add(**writer, port, i, i);
  }
  ASSERT_GT(on_disk(), 2 * kLeastRecording);
  auto options = quick(file());
  options.append = true;
  options.max_bytes = kLeastRecording;
  options.full = Full::oldest;
  {
    auto writer = RecordingWriter::create(options);
    ASSERT_TRUE(writer);
    const auto port = (*writer)->add_port(number_port());
    for (int i = 0; i < 200; ++i) {
      add(**writer, port, i, i);
      settle(**writer, static_cast<std::uint64_t>(i + 1));
    }
  }
  EXPECT_LE(on_disk(), kLeastRecording);
}

TEST_F(RecordingFile, CountsSamplesLostBecauseTheQueueIsFull) {
  auto options = quick(file());
  options.flush = std::chrono::hours{1};
  options.queue_bytes = 1000;
  auto writer = RecordingWriter::create(options);
  ASSERT_TRUE(writer);
  const auto port = (*writer)->add_port(number_port());
  std::vector<std::byte> large(2000);
  (*writer)->add(port, 1, large.data(), large.size());
  EXPECT_EQ(1U, (*writer)->health().lost);
  add(**writer, port, 2, 2);
  ASSERT_TRUE((*writer)->finish());
  EXPECT_EQ(1U, (*writer)->health().samples);
  EXPECT_EQ(1U, (*writer)->health().lost);
  auto recording = Recording::open(file());
  ASSERT_TRUE(recording) << to_text(recording.problems());
  EXPECT_EQ(1U, recording->ports()[0].missing);
}

TEST_F(RecordingFile, KeepsTheNumberOfSamplesLostBeforeEachSample) {
  auto writer = RecordingWriter::create(quick(file()));
  ASSERT_TRUE(writer);
  const auto one = (*writer)->add_port(number_port("d.m.one"));
  const auto two = (*writer)->add_port(number_port("d.m.two"));
  add(**writer, one, 1, 1);
  (*writer)->miss(one, 2);
  (*writer)->miss(one, 1);
  add(**writer, two, 2, 2);
  add(**writer, one, 3, 3);
  add(**writer, one, 4, 4);
  (*writer)->miss(two, 5);
  ASSERT_TRUE((*writer)->finish());
  EXPECT_EQ(8U, (*writer)->health().lost);
  auto recording = Recording::open(file());
  ASSERT_TRUE(recording) << to_text(recording.problems());
  EXPECT_EQ(3U, recording->ports()[0].missing);
  EXPECT_EQ(0U, recording->ports()[1].missing) << "no later sample shows where the lost ones were";
  std::vector<std::uint64_t> missing;
  for (const RecordedSample& sample : all(*recording)) missing.push_back(sample.missing);
  EXPECT_EQ((std::vector<std::uint64_t>{0, 0, 3, 0}), missing);
}

TEST_F(RecordingFile, LosesNoSamplesWhileAnotherProgramLocksIt) {
  auto options = quick(file());
  auto writer = RecordingWriter::create(options);
  ASSERT_TRUE(writer);
  const auto port = (*writer)->add_port(number_port());
  add(**writer, port, 1, 1);
  settle(**writer, 1);
  {
    // A second connection locks the file, as another program would.
    auto other = Database::open(file(), Access::append);
    ASSERT_TRUE(other);
    ASSERT_TRUE(other->run("BEGIN IMMEDIATE"));
    add(**writer, port, 2, 2);
    while (!(*writer)->health().trouble) std::this_thread::sleep_for(std::chrono::milliseconds{5});
    EXPECT_THAT((*writer)->health().trouble->what, HasSubstr("another program"));
    EXPECT_EQ(1U, (*writer)->health().samples);
    other->roll_back();
  }
  ASSERT_TRUE((*writer)->finish());
  EXPECT_EQ(2U, (*writer)->health().samples);
  EXPECT_EQ(0U, (*writer)->health().lost);
}

TEST_F(RecordingFile, ReportsInvalidSamplesAndDamage) {
  {
    auto writer = RecordingWriter::create(quick(file()));
    ASSERT_TRUE(writer);
    const auto port = (*writer)->add_port(number_port());
    for (int i = 0; i < 20'000; ++i) add(**writer, port, i, i);
    const std::byte half[6]{};
    (*writer)->add(port, 5, half, sizeof half);
  }
  auto recording = Recording::open(file());
  ASSERT_TRUE(recording);
  std::uint64_t wrong = 0;
  std::uint64_t right = 0;
  const auto count = [&](const RecordedSample&) { return ++right, true; };
  ASSERT_TRUE(recording->read({}, count, wrong));
  EXPECT_EQ(1U, wrong);
  EXPECT_EQ(20'000U, right);

  const auto size = std::filesystem::file_size(file());
  {
    std::fstream damage{file(), std::ios::in | std::ios::out | std::ios::binary};
    damage.seekp(static_cast<std::streamoff>(size / 2));
    for (int i = 0; i < 20'000; ++i) damage.put('\x55');
  }
  auto damaged = Recording::open(file());
  Result<void> read;
  if (damaged) read = damaged->read({}, count, wrong);
  EXPECT_THAT(to_text(damaged ? read.problems() : damaged.problems()), HasSubstr("is damaged"));
}

TEST_F(RecordingFile, CanBeReadWhileItIsWritten) {
  auto writer = RecordingWriter::create(quick(file()));
  ASSERT_TRUE(writer);
  const auto port = (*writer)->add_port(number_port());
  for (int i = 0; i < 100; ++i) add(**writer, port, i, i);
  settle(**writer, 100);
  auto recording = Recording::open(file());
  ASSERT_TRUE(recording) << to_text(recording.problems());
  EXPECT_EQ(100U, all(*recording).size());
}

/// While this object exists, this thread has the file rights of an ordinary user, even if the test runs as
/// root.
class OrdinaryUser {
 public:
  OrdinaryUser() : before_(::setfsuid(65534)) {}
  ~OrdinaryUser() { ::setfsuid(static_cast<uid_t>(before_)); }
  OrdinaryUser(const OrdinaryUser&) = delete;
  OrdinaryUser& operator=(const OrdinaryUser&) = delete;

 private:
  int before_;
};

TEST_F(RecordingFile, CanBeReadFromAReadOnlyFolder) {
  RecordingOptions options = quick(file());
  options.max_bytes = 0;  // then the samples stay in the log
  auto writer = RecordingWriter::create(options);
  ASSERT_TRUE(writer);
  const auto port = (*writer)->add_port(number_port());
  for (int i = 0; i < 100; ++i) add(**writer, port, i, i);
  settle(**writer, 100);
  // These are the files that a killed recorder leaves, without FILE-shm, as in a backup.
  const std::filesystem::path disc = folder_ / "disc %41?#";
  const auto copy = [&](const std::string& suffix, const std::string& name) {
    std::filesystem::copy_file(file() + suffix, disc / (name + suffix));
  };
  std::filesystem::create_directory(disc);
  copy("", "with-log");
  copy("-wal", "with-log");
  {
    auto database = Database::open(file(), Access::append);
    ASSERT_TRUE(database);
    ASSERT_TRUE(database->run("PRAGMA wal_checkpoint(TRUNCATE)"));
  }
  copy("", "empty-log");
  copy("-wal", "empty-log");
  copy("", "without-log");
  std::filesystem::permissions(disc, std::filesystem::perms{0555});
  {
    const OrdinaryUser user;
    for (const char* const name : {"with-log", "empty-log", "without-log"}) {
      auto recording = Recording::open(disc / name);
      ASSERT_TRUE(recording) << name << ": " << to_text(recording.problems());
      EXPECT_EQ(100U, all(*recording).size()) << name;
    }
  }
  std::filesystem::permissions(disc, std::filesystem::perms{0755});
  EXPECT_EQ(5, std::distance(std::filesystem::directory_iterator{disc}, {})) << "a reader has left a file";
}

TEST_F(RecordingFile, CanBeReadByTimeAndPort) {
  {
    auto writer = RecordingWriter::create(quick(file()));
    ASSERT_TRUE(writer);
    const auto one = (*writer)->add_port(number_port("d.m.one"));
    const auto two = (*writer)->add_port(number_port("d.m.two"));
    for (int i = 0; i < 10; ++i) add(**writer, i % 2 == 0 ? one : two, i, i);
  }
  auto recording = Recording::open(file());
  ASSERT_TRUE(recording);
  std::vector<std::int64_t> times;
  std::uint64_t wrong = 0;
  ASSERT_TRUE(recording->read(
      {{recording->ports()[1].id}, 3, 7},
      [&](const RecordedSample& s) { return times.push_back(s.time_ns), true; }, wrong));
  EXPECT_THAT(times, testing::ElementsAre(3, 5, 7));
}

}  // namespace
}  // namespace takt::recording::writer_test
