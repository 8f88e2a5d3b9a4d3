#include <takt/recording/writer.hpp>

#include <algorithm>
#include <filesystem>
#include <utility>

#include <takt/core/words.hpp>
#include <takt/os/clock.hpp>

namespace takt::recording {

namespace {

constexpr Nanoseconds kTryAgain = std::chrono::seconds{1};  // time from a disk error to the next attempt
constexpr std::uint64_t kOverhead = 24;  // estimated size of a row without its sample, in bytes
constexpr std::uint64_t kLargestLog = 16'000'000;

std::uint64_t size_of(const std::string& file) {
  std::error_code none;
  const auto size = std::filesystem::file_size(file, none);
  return none ? 0 : size;
}

Result<void> check_version(Database& database) {
  const auto id = database.number("PRAGMA application_id");
  if (!id) return id.problems();
  const auto version = database.number("PRAGMA user_version");
  if (!version) return version.problems();
  const std::string where = on_one_line(database.file());
  if (*id != kRecordingId) return Problem{where, "is not a recording", "create a recording with takt record"};
  if (*version != kRecordingVersion)
    return Problem{where, "has recording format " + std::to_string(*version),
                   "use a Takt version that writes it; this one writes only format " +
                       std::to_string(kRecordingVersion)};
  return {};
}

}  // namespace

RecordingWriter::RecordingWriter(RecordingOptions options, Database database)
    : options_(std::move(options)), database_(std::move(database)) {}

Result<std::unique_ptr<RecordingWriter>> RecordingWriter::create(const RecordingOptions& options) {
  std::error_code none;
  const bool there = std::filesystem::exists(options.file, none);
  const std::string where = on_one_line(options.file);
  if (options.max_bytes != 0 && options.max_bytes < kLeastRecording)
    return Problem{where, "a size limit of " + std::to_string(options.max_bytes) + " bytes is too small",
                   "use at least 1 MB"};
  // SQLite creates further files beside a recording, and a device cannot be recorded into.
  if (there && !std::filesystem::is_regular_file(options.file, none))
    return Problem{where, "is not a regular file", "record into another file"};
  if (there && !options.append)
    return Problem{where, "exists already", "use --append to add samples to it, or record into another file"};
  auto database = Database::open(options.file, there ? Access::append : Access::create);
  if (!database) return database.problems();
  std::unique_ptr<RecordingWriter> writer{new RecordingWriter{options, std::move(*database)}};
  const auto tables = writer->database_.number("SELECT count(*) FROM sqlite_master");
  if (!tables) return tables.problems();
  // An empty file is accepted, because a recorder that is killed at its start leaves an empty file.
  if (*tables != 0) {
    if (auto right = check_version(writer->database_); !right) return right.problems();
  }
  if (auto prepared = writer->prepare(); !prepared) return prepared.problems();
  RecordingWriter& self = *writer;
  auto thread = os::Thread::start(
      {.name = "takt-recording"}, [&self] { self.work(); }, nullptr);
  if (!thread) return thread.problems();
  writer->thread_ = std::move(*thread);
  return writer;
}

RecordingWriter::~RecordingWriter() { static_cast<void>(finish()); }

Result<void> RecordingWriter::prepare() {
  const auto tables = database_.number("SELECT count(*) FROM sqlite_master");
  if (!tables) return tables.problems();
  if (*tables == 0) {
    // auto_vacuum must be set while the file is empty. Otherwise the file could not shrink later.
    auto made = database_.run("PRAGMA auto_vacuum=INCREMENTAL; PRAGMA journal_mode=WAL; BEGIN IMMEDIATE;" +
                              std::string{kSchema} + "PRAGMA application_id=" + std::to_string(kRecordingId) +
                              "; PRAGMA user_version=" + std::to_string(kRecordingVersion) +
                              "; INSERT INTO meta VALUES('version','" + std::to_string(kRecordingVersion) +
                              "'),('begin_ns','" + std::to_string(os::wall_ns()) + "'); COMMIT");
    if (!made) {
      database_.roll_back();
      return made;
    }
  }
  // With these settings, SQLite does not wait for the disk at every commit. After a power failure, the last
  // commits may be missing, but the rest is intact.
  if (auto set = database_.run("PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL"); !set) return set;
  const auto page = database_.number("PRAGMA page_size");
  if (!page) return page.problems();
  page_ = static_cast<std::uint64_t>(*page);
  log_room_ = options_.max_bytes == 0 ? kLargestLog : std::min(options_.max_bytes / 4, kLargestLog);

  auto ports = Statement::prepare(database_, "SELECT id, path, topic, reliable, type FROM port");
  if (!ports) return ports.problems();
  for (;;) {
    const auto row = ports->step();
    if (!row) return row.problems();
    if (!*row) break;
    known_[{ports->text(1), ports->text(2), ports->number(3) != 0, ports->text(4)}] = ports->number(0);
    last_port_ = std::max(last_port_, ports->number(0));
  }
  auto insert =
      Statement::prepare(database_, "INSERT INTO sample(port, time_ns, missing, bytes) VALUES(?, ?, ?, ?)");
  if (!insert) return insert.problems();
  insert_.emplace(std::move(*insert));
  measure();
  return {};
}

std::int64_t RecordingWriter::add_port(const RecordedPort& port, const std::string& cell) {
  const std::lock_guard lock{mutex_};
  auto [found, is_new] =
      known_.try_emplace({port.path, port.topic, port.reliable, model::to_text(port.type)}, 0);
  if (is_new) {
    found->second = ++last_port_;
    waiting_.ports.push_back({found->second, port});
  }
  if (!cell.empty()) waiting_.cell = cell;
  return found->second;
}

void RecordingWriter::add(std::int64_t port, std::int64_t time_ns, const std::byte* bytes, std::size_t size) {
  const std::lock_guard lock{mutex_};
  if (ending_ || health_.full) return;
  if (taken_bytes_ + waiting_.bytes.size() + size + (waiting_.samples.size() + 1) * sizeof(Waiting) >
      options_.queue_bytes) {
    ++missing_[port];
    ++health_.lost;
    return;
  }
  waiting_.samples.push_back({port, time_ns, std::exchange(missing_[port], 0), size});
  waiting_.bytes.insert(waiting_.bytes.end(), bytes, bytes + size);
  // Wake the writer's thread once, long before the queue is full.
  const std::size_t early = options_.queue_bytes / 4;
  if (waiting_.bytes.size() >= early && waiting_.bytes.size() - size < early) news_.notify_one();
}

void RecordingWriter::miss(std::int64_t port, std::uint64_t count) {
  const std::lock_guard lock{mutex_};
  if (ending_ || health_.full) return;
  missing_[port] += count;
  health_.lost += count;
}

RecordingHealth RecordingWriter::health() const {
  const std::lock_guard lock{mutex_};
  return health_;
}

std::map<std::int64_t, std::uint64_t> RecordingWriter::counts() const {
  const std::lock_guard lock{mutex_};
  return counts_;
}

void RecordingWriter::work() {
  Batch batch;
  bool failed = false;
  for (;;) {
    bool ending = false;
    {
      std::unique_lock lock{mutex_};
      news_.wait_for(lock, failed ? std::max(kTryAgain, options_.flush) : options_.flush, [&] {
        return ending_ || (!failed && waiting_.bytes.size() >= options_.queue_bytes / 4);
      });
      ending = ending_;
      if (batch.empty()) {
        std::swap(batch, waiting_);
        taken_bytes_ = batch.bytes.size() + batch.samples.size() * sizeof(Waiting);
      }
    }
    const auto written = write(batch);
    failed = !written;
    measure();
    const std::lock_guard lock{mutex_};
    taken_bytes_ = batch.bytes.size() + batch.samples.size() * sizeof(Waiting);
    health_.trouble = failed ? std::optional{written.problems().front()} : std::nullopt;
    if (!ending || (!failed && !waiting_.empty())) continue;
    health_.lost += batch.samples.size() + waiting_.samples.size();
    return;
  }
}

Result<void> RecordingWriter::write(Batch& batch) {
  if (!batch.ports.empty() || !batch.cell.empty()) {
    if (auto written = write_ports(batch); !written) {
      database_.roll_back();
      return written;
    }
    batch.ports.clear();
    batch.cell.clear();
  }
  // Once the file is full, smaller samples that come later are not written either, because they would follow
  // a gap.
  if (health().full) batch.samples.clear();
  std::size_t first = 0;
  std::size_t offset = 0;
  Result<void> outcome;
  while (first < batch.samples.size()) {
    const auto next = write_samples(batch, first, offset);
    if (!next) {
      database_.roll_back();
      outcome = next.problems();
      break;
    }
    if (*next == first) {  // the file is full
      const std::lock_guard lock{mutex_};
      health_.full = true;
      first = batch.samples.size();
      break;
    }
    const std::lock_guard lock{mutex_};
    for (; first < *next; ++first) {
      offset += batch.samples[first].size;
      ++counts_[batch.samples[first].port];
      ++health_.samples;
    }
  }
  if (first == batch.samples.size()) {
    batch.samples.clear();
    batch.bytes.clear();
  } else {
    batch.samples.erase(batch.samples.begin(), batch.samples.begin() + static_cast<std::ptrdiff_t>(first));
    batch.bytes.erase(batch.bytes.begin(), batch.bytes.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  return outcome;
}

Result<void> RecordingWriter::write_ports(const Batch& batch) {
  if (auto begun = database_.run("BEGIN IMMEDIATE"); !begun) return begun;
  auto port = Statement::prepare(
      database_, "INSERT INTO port(id, path, topic, reliable, type_name, type) VALUES(?, ?, ?, ?, ?, ?)");
  if (!port) return port.problems();
  for (const NewPort& each : batch.ports) {
    const std::string type = model::to_text(each.port.type);
    port->bind(1, each.id);
    port->bind(2, each.port.path);
    port->bind(3, each.port.topic);
    port->bind(4, std::int64_t{each.port.reliable});
    port->bind(5, each.port.type.name);
    port->bind(6, type);
    const auto done = port->step();
    port->reset();
    if (!done) return done.problems();
  }
  if (!batch.cell.empty()) {
    auto cell = Statement::prepare(database_, "INSERT OR IGNORE INTO meta VALUES('cell', ?)");
    if (!cell) return cell.problems();
    cell->bind(1, batch.cell);
    if (const auto done = cell->step(); !done) return done.problems();
  }
  return database_.run("COMMIT");
}

Result<std::size_t> RecordingWriter::write_samples(const Batch& batch, std::size_t first,
                                                   std::size_t offset) {
  // SQLite's log must hold a whole transaction, so a transaction is limited to a quarter of the log. But it
  // contains at least one sample.
  std::size_t next = first;
  std::uint64_t bytes = 0;
  do bytes += batch.samples[next++].size + kOverhead;
  while (next < batch.samples.size() && bytes + batch.samples[next].size + kOverhead < log_room_ / 4);

  const auto room = make_room(bytes + bytes / 8 + 4 * page_);
  if (!room) return room.problems();
  if (!*room) return first;
  if (auto begun = database_.run("BEGIN IMMEDIATE"); !begun) return begun.problems();
  for (std::size_t i = first; i < next; ++i) {
    const Waiting& sample = batch.samples[i];
    insert_->bind(1, sample.port);
    insert_->bind(2, sample.time_ns);
    insert_->bind(3, static_cast<std::int64_t>(sample.missing));
    insert_->bind(4, batch.bytes.data() + offset, sample.size);
    const auto done = insert_->step();
    insert_->reset();
    if (!done) return done.problems();
    offset += sample.size;
  }
  if (auto done = database_.run("COMMIT"); !done) return done.problems();
  // An error of the checkpoint is ignored: SQLite's log is part of the recording, and a later checkpoint can
  // move the log's content into the main file.
  static_cast<void>(checkpoint());
  return next;
}

Result<std::uint64_t> RecordingWriter::used() {
  const auto pages = database_.number("PRAGMA page_count");
  if (!pages) return pages.problems();
  const auto free = database_.number("PRAGMA freelist_count");
  if (!free) return free.problems();
  return static_cast<std::uint64_t>(*pages - *free) * page_;
}

Result<bool> RecordingWriter::make_room(std::uint64_t bytes) {
  if (options_.max_bytes == 0) return true;
  const std::uint64_t bound = options_.max_bytes - log_room_;
  // SQLite's log may be too large because another program is reading it. Then SQLite cannot move the log's
  // content into the main file.
  if (size_of(options_.file + "-wal") > log_room_) {
    if (auto done = database_.run("PRAGMA wal_checkpoint(TRUNCATE)"); !done) return done.problems();
    if (size_of(options_.file + "-wal") > log_room_)
      return Problem{on_one_line(options_.file),
                     "another program has kept it open for reading, so its log has become too large",
                     "end that program"};
  }
  for (;;) {
    const auto now = used();
    if (!now) return now.problems();
    if (*now + bytes <= bound) break;
    if (options_.full == Full::stop) return false;
    const auto oldest = database_.number("SELECT min(id) FROM sample");
    if (!oldest) return oldest.problems();
    const auto newest = database_.number("SELECT max(id) FROM sample");
    if (!newest) return newest.problems();
    if (*newest == 0) return false;  // a single sample is larger than the limit
    // Delete a little more than needed, so that not every batch needs a deletion. Delete in portions that fit
    // into SQLite's log.
    const std::uint64_t all = static_cast<std::uint64_t>(*newest - *oldest + 1);
    const std::uint64_t each = std::max<std::uint64_t>(1, *now / all);
    const std::uint64_t excess = std::min(*now + bytes - bound + bound / 16, log_room_ / 4);
    const std::int64_t last =
        *oldest + static_cast<std::int64_t>(std::clamp<std::uint64_t>(excess / each, 1, all)) - 1;
    if (auto done = database_.run("DELETE FROM sample WHERE id <= " + std::to_string(last)); !done)
      return done.problems();
    {
      const std::lock_guard lock{mutex_};
      health_.dropped += static_cast<std::uint64_t>(database_.changed());
    }
    if (auto done = checkpoint(); !done) return done.problems();
  }
  // SQLite reuses the pages of deleted samples. If the file had a larger limit before, the pages beyond the
  // limit are returned to the file system.
  const auto pages = database_.number("PRAGMA page_count");
  if (!pages) return pages.problems();
  if (static_cast<std::uint64_t>(*pages) * page_ > bound) {
    const std::uint64_t most = std::max<std::uint64_t>(1, log_room_ / 4 / page_);
    if (auto done = database_.run("PRAGMA incremental_vacuum(" + std::to_string(most) + ")"); !done)
      return done.problems();
    if (auto done = checkpoint(); !done) return done.problems();
  }
  return true;
}

Result<void> RecordingWriter::checkpoint() {
  return options_.max_bytes == 0 ? Result<void>{} : database_.run("PRAGMA wal_checkpoint(PASSIVE)");
}

void RecordingWriter::measure() {
  const std::uint64_t bytes = size_of(options_.file) + size_of(options_.file + "-wal");
  const std::lock_guard lock{mutex_};
  health_.bytes = bytes;
}

Result<void> RecordingWriter::finish() {
  if (finished_) return {};
  finished_ = true;
  {
    const std::lock_guard lock{mutex_};
    ending_ = true;
  }
  news_.notify_one();
  if (thread_.running()) thread_.join();
  insert_.reset();
  // Remove SQLite's log file. This fails if another program has the recording open; then the log file stays.
  if (!health_.trouble) static_cast<void>(database_.run("PRAGMA journal_mode=DELETE"));
  measure();
  if (health_.trouble) return *health_.trouble;
  return {};
}

}  // namespace takt::recording
