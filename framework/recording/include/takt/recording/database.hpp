// Wraps SQLite for recordings. Only database.cpp includes SQLite's header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>

struct sqlite3;
struct sqlite3_stmt;

namespace takt::recording {

enum class Access { read, append, create };

/// One open SQLite file. Only one thread at a time may use this object. Every error names the file and states
/// what to do.
class Database {
 public:
  /// Opens a file. With Access::create the file must not exist; with other kinds of access it must exist.
  /// With Access::read, this user needs no right to write to the file or its folder.
  static Result<Database> open(const std::string& file, Access access);

  /// Runs one or more statements without results.
  Result<void> run(const std::string& sql);
  /// Runs a query and returns the first column of the first row; 0 if there is no row.
  Result<std::int64_t> number(const std::string& sql);
  /// The number of rows that the last statement changed.
  [[nodiscard]] std::int64_t changed() const;
  /// Rolls back the current transaction, if there is one.
  void roll_back();
  /// The error of the last call.
  [[nodiscard]] Problem problem() const;
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  friend class Statement;
  struct Close {
    void operator()(sqlite3* database) const;
  };
  Database(std::string file, std::unique_ptr<sqlite3, Close> open)
      : file_(std::move(file)), open_(std::move(open)) {}
  /// Opens a file for reading without creating SQLite's index of the log (FILE-shm) beside it. Only for a
  /// file that nobody writes: a recorder that runs has created the index.
  static Result<Database> open_unchanged(const std::string& file);

  std::string file_;
  std::unique_ptr<sqlite3, Close> open_;
};

/// A prepared statement. The database must outlive the statement.
class Statement {
 public:
  static Result<Statement> prepare(Database& database, const std::string& sql);

  /// Sets a parameter of the statement. The first parameter has place 1. Text and bytes must stay in memory
  /// until reset().
  void bind(int place, std::int64_t value);
  void bind(int place, std::string_view text);
  void bind(int place, const std::byte* bytes, std::size_t size);
  /// Runs the statement up to its next row. Returns false if there is no further row.
  Result<bool> step();
  void reset();

  /// The value of a column of the present row. The first column is 0. Bytes are valid until the next step().
  [[nodiscard]] std::int64_t number(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] std::pair<const std::byte*, std::size_t> bytes(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  Statement(Database& database, std::unique_ptr<sqlite3_stmt, Finalize> prepared)
      : database_(&database), prepared_(std::move(prepared)) {}

  Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> prepared_;
};

}  // namespace takt::recording
