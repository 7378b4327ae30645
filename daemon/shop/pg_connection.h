#pragma once
// One connection to a PostgreSQL server, by libpq without blocking: every wait has an end, and can be ended.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// A parameter of a statement: text, or bytes as they are.
struct PgValue {
  std::string text;
  bool bytes = false;
  PgValue(std::string value) : text(std::move(value)) {}         // NOLINT: a text is a value
  PgValue(const char* value) : text(value) {}                    // NOLINT
  PgValue(std::uint64_t value) : text(std::to_string(value)) {}  // NOLINT
  PgValue(bool value) : text(value ? "true" : "false") {}        // NOLINT
  PgValue(std::string value, bool as_bytes) : text(std::move(value)), bytes(as_bytes) {}
};

using PgRow = std::vector<std::string>;  ///< NULL is empty
struct PgRows {
  std::vector<PgRow> rows;
};

/// Asks a database. Errors: as PgConnection::ask.
using ShopAsk = std::function<Result<PgRows>(const std::string& sql, const std::vector<PgValue>& values)>;

/// The address has no password and is one that libpq understands. Errors: kInput, without the address.
Result<void> check_pg_url(const std::string& url);

/// Names of hosts are resolved by the system, which may block: `connect` alone does.
class PgConnection {
 public:
  static constexpr std::chrono::seconds kPatience{15};

  /// To a server that takes writes. `stop`: a descriptor that can be read when every wait is to end; -1:
  /// none. Errors: kLink with libpq's words, kInput (the address), kCancelled.
  static Result<PgConnection> connect(const std::string& url, int stop,
                                      std::chrono::milliseconds patience = kPatience);
  PgConnection(PgConnection&&) noexcept;
  PgConnection& operator=(PgConnection&&) = delete;
  ~PgConnection();

  /// One statement, its parameters as $1, $2 ... Errors: kInput: the server refuses it, the connection
  /// stays; kUsage: the tables of a shop are not there; kLink: the connection is lost, and nobody knows
  /// whether it was done; kCancelled likewise.
  Result<PgRows> ask(const std::string& sql, const std::vector<PgValue>& values = {});
  /// Until a notification has come, `wake` can be read, `stop` can, or the time is over. True: something
  /// came. Errors: kLink.
  Result<bool> wait(int wake, std::chrono::milliseconds most);
  /// Those that have come so far are no reason any more for `wait` to return. Errors: kLink.
  Result<void> forget_notifications();
  bool lost() const;
  /// Asked although `stop` can be read, for so long at most; the connection is of no use afterwards.
  Result<PgRows> last_words(const std::string& sql, const std::vector<PgValue>& values,
                            std::chrono::milliseconds most);

 private:
  struct Pg;
  explicit PgConnection(std::unique_ptr<Pg> pg);
  std::unique_ptr<Pg> pg_;
};

}  // namespace tiltfeed::daemon
