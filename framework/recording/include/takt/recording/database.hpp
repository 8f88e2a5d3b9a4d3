// SQLite, as far as recordings need it. Its header is named in database.cpp and nowhere else.
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

/// One open file. One thread at a time. Every failure names the file and says what would help.
class Database {
 public:
  /// With Access::create there must be no such file, with the others there must be one.
  static Result<Database> open(const std::string& file, Access access);

  /// One statement or several, without results.
  Result<void> run(const std::string& sql);
  /// The first column of the first row; 0 where there is none.
  Result<std::int64_t> number(const std::string& sql);
  /// How many rows the last statement changed.
  [[nodiscard]] std::int64_t changed() const;
  /// Gives up what was begun, if anything was.
  void roll_back();
  /// What the last call complained of.
  [[nodiscard]] Problem problem() const;
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  friend class Statement;
  struct Close {
    void operator()(sqlite3* database) const;
  };
  Database(std::string file, std::unique_ptr<sqlite3, Close> open)
      : file_(std::move(file)), open_(std::move(open)) {}

  std::string file_;
  std::unique_ptr<sqlite3, Close> open_;
};

/// A statement that is run again and again. The database outlives it.
class Statement {
 public:
  static Result<Statement> prepare(Database& database, const std::string& sql);

  /// The values of its parameters, the first at place 1, until reset(). Text and bytes must live until then.
  void bind(int place, std::int64_t value);
  void bind(int place, std::string_view text);
  void bind(int place, const std::byte* bytes, std::size_t size);
  /// True with a row, false at the end.
  Result<bool> step();
  void reset();

  /// Of the present row, the first column at place 0. Views live until the next step.
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
