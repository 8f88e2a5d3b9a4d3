#include <takt/recording/database.hpp>

#include <filesystem>
#include <utility>

#include <sqlite3.h>

#include <takt/core/words.hpp>
#include <takt/os/output_file.hpp>

namespace takt::recording {

namespace {

constexpr int kBusy_ms = 2000;  // the time to wait while another program writes the file

Problem problem_of(sqlite3* database, const std::string& file) {
  const int code = database == nullptr ? SQLITE_NOMEM : sqlite3_errcode(database);
  const std::string words = database == nullptr ? "no memory" : sqlite3_errmsg(database);
  const std::string where = on_one_line(file);
  switch (code & 0xFF) {
    case SQLITE_FULL:
      return {where, "the disk is full", "free disk space, or record into another file"};
    case SQLITE_CANTOPEN:
      return {where, "cannot be opened: " + words, "check that the file exists and that you may open it"};
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return {where, "cannot be written: " + words, "check the permissions of the file and its folder"};
    case SQLITE_IOERR:
      return {where, "cannot be read or written: " + words, "check the disk"};
    case SQLITE_NOTADB:
      return {where, "is not a recording", "create a recording with takt record"};
    case SQLITE_CORRUPT:
      return {where, "is damaged: " + words, "run sqlite3 FILE .recover to extract the readable part"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {where, "is locked by another program: " + words, "end that program, then try again"};
    default:
      return {where, words, ""};
  }
}

// Returns the path as a URI, to which parameters of SQLite can be added.
std::string uri_of(const std::string& file) {
  std::string uri = "file://";
  for (const char letter : std::filesystem::absolute(file).string()) {
    if (letter == '%' || letter == '?' || letter == '#')
      uri += letter == '%' ? "%25" : letter == '?' ? "%3f" : "%23";
    else
      uri += letter;
  }
  return uri;
}

}  // namespace

void Database::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

Result<Database> Database::open(const std::string& file, Access access) {
  int flags = SQLITE_OPEN_NOMUTEX;
  flags |= access == Access::read     ? SQLITE_OPEN_READONLY
           : access == Access::append ? SQLITE_OPEN_READWRITE
                                      : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &raw, flags, nullptr);
  std::unique_ptr<sqlite3, Close> opened{raw};
  if (code == SQLITE_CANTOPEN && access == Access::create) {
    if (const auto missing = os::missing_folder(file)) return *missing;
  }
  if (code != SQLITE_OK) return problem_of(raw, file);
  sqlite3_busy_timeout(raw, kBusy_ms);
  if (access == Access::read) {
    const int probe = sqlite3_exec(raw, "SELECT 1 FROM sqlite_master", nullptr, nullptr, nullptr) & 0xFF;
    if (probe == SQLITE_CANTOPEN || probe == SQLITE_READONLY) return open_unchanged(file);
  }
  return Database{file, std::move(opened)};
}

Result<Database> Database::open_unchanged(const std::string& file) {
  // An immutable file is read without its log. With a log, SQLite keeps the index of the log in memory only
  // for the sole user of the file, who locks it exclusively. Without locks, a reader can do so.
  std::error_code none;
  const bool has_log = std::filesystem::exists(file + "-wal", none);
  const std::string uri = uri_of(file) + (has_log ? "?vfs=unix-none" : "?immutable=1");
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(uri.c_str(), &raw,
                                   SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
  Database database{file, std::unique_ptr<sqlite3, Close>{raw}};
  if (code != SQLITE_OK) return database.problem();
  if (auto set = database.run("PRAGMA locking_mode=EXCLUSIVE"); !set) return set.problems();
  return database;
}

Result<void> Database::run(const std::string& sql) {
  if (sqlite3_exec(open_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) return problem();
  return {};
}

Result<std::int64_t> Database::number(const std::string& sql) {
  auto statement = Statement::prepare(*this, sql);
  if (!statement) return statement.problems();
  const auto row = statement->step();
  if (!row) return row.problems();
  return *row ? statement->number(0) : 0;
}

std::int64_t Database::changed() const { return sqlite3_changes64(open_.get()); }

void Database::roll_back() {
  if (sqlite3_get_autocommit(open_.get()) == 0) static_cast<void>(run("ROLLBACK"));
}

Problem Database::problem() const { return problem_of(open_.get(), file_); }

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Result<Statement> Statement::prepare(Database& database, const std::string& sql) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database.open_.get(), sql.c_str(), static_cast<int>(sql.size()), &raw, nullptr) !=
      SQLITE_OK)
    return database.problem();
  return Statement{database, std::unique_ptr<sqlite3_stmt, Finalize>{raw}};
}

void Statement::bind(int place, std::int64_t value) { sqlite3_bind_int64(prepared_.get(), place, value); }

void Statement::bind(int place, std::string_view text) {
  sqlite3_bind_text64(prepared_.get(), place, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
}

void Statement::bind(int place, const std::byte* bytes, std::size_t size) {
  sqlite3_bind_blob64(prepared_.get(), place, bytes, size, SQLITE_STATIC);
}

Result<bool> Statement::step() {
  const int code = sqlite3_step(prepared_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  const Problem problem = database_->problem();
  reset();
  return problem;
}

void Statement::reset() { sqlite3_reset(prepared_.get()); }

std::int64_t Statement::number(int column) const { return sqlite3_column_int64(prepared_.get(), column); }

std::string Statement::text(int column) const {
  const unsigned char* text = sqlite3_column_text(prepared_.get(), column);
  const int size = sqlite3_column_bytes(prepared_.get(), column);
  return text == nullptr ? std::string{}
                         : std::string{reinterpret_cast<const char*>(text), static_cast<std::size_t>(size)};
}

std::pair<const std::byte*, std::size_t> Statement::bytes(int column) const {
  const void* bytes = sqlite3_column_blob(prepared_.get(), column);
  return {static_cast<const std::byte*>(bytes),
          static_cast<std::size_t>(sqlite3_column_bytes(prepared_.get(), column))};
}

}  // namespace takt::recording
