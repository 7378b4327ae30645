#pragma once
// The connection to a spool's table, and its statements: for the sources of the spool alone.

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

#include "kinematics/basics/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace tiltfeed::daemon {

/// A statement from its text to its end.
struct SpoolStatement {
  sqlite3_stmt* s = nullptr;
  SpoolStatement() = default;
  SpoolStatement(const SpoolStatement&) = delete;
  SpoolStatement& operator=(const SpoolStatement&) = delete;
  ~SpoolStatement();
  /// Of the row that was stepped to; columns count from 0.
  std::string text(int column) const;
  std::uint64_t number(int column) const;
  double real(int column) const;
  bool known(int column) const;
  /// Steps to the end of a statement that gives no row; false: the table could not.
  bool finish();
  /// Parameters count from 1; what is never bound is NULL.
  void bind(int at, const std::string& value);
  void bind(int at, std::uint64_t value);
  void bind(int at, double value);
  template <class T>
  void bind(int at, const std::optional<T>& value) {
    using Column = std::conditional_t<std::is_floating_point_v<T>, double, std::uint64_t>;
    if (value) bind(at, static_cast<Column>(*value));
  }
};

/// The table's file by the folder's own name: SQLite takes no link on the whole way to it, and only the file
/// itself must be none.
std::string table_path(const std::string& folder);

struct SpoolTable {
  sqlite3* db = nullptr;
  bool keeps_files = false;
  SpoolTable() = default;
  SpoolTable(const SpoolTable&) = delete;
  SpoolTable& operator=(const SpoolTable&) = delete;
  ~SpoolTable();
  /// The log's files stay when the table is closed, the log empty: it can be opened on a disk without room.
  void keep_files();
  /// What SQLite said last. kIo.
  Error error(const std::string& folder) const;
  /// Whether that was for a disk or a quota without room.
  bool lacks_room(const std::string& folder) const;
  bool prepare(SpoolStatement& statement, const std::string& sql) const;
  /// Runs one statement with these values for its parameters; false: the table could not.
  template <class... Values>
  bool run(const char* sql, const Values&... values) const {
    SpoolStatement statement;
    if (!prepare(statement, sql)) return false;
    int at = 0;
    (statement.bind(++at, values), ...);
    return statement.finish();
  }
};

}  // namespace tiltfeed::daemon
