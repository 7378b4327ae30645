#include "daemon/shop/pg_connection.h"

#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <cstring>

#include "config/queue_key.h"

namespace tiltfeed::daemon {

namespace {

using std::chrono::steady_clock;

/// What the address does not say otherwise. A partition is noticed within half a minute.
constexpr std::pair<const char*, const char*> kUsual[] = {
    {"target_session_attrs", "read-write"}, {"connect_timeout", "10"},
    {"application_name", "tiltfeed"},       {"keepalives_idle", "10"},
    {"keepalives_interval", "5"},           {"keepalives_count", "3"},
    {"tcp_user_timeout", "20000"},          {"client_encoding", "UTF8"}};
/// The server ends what takes longer, ms: a lock that somebody has left.
constexpr const char* kLimits =
    "SET statement_timeout = 10000; SET lock_timeout = 8000; SET idle_in_transaction_session_timeout = 30000";
/// SQLSTATE of a schema, a table or a function that is not there.
constexpr const char* kNoSuch[] = {"3F000", "42P01", "42883"};

std::string one_line(const char* text) {
  std::string line = text != nullptr ? text : "";
  while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) line.pop_back();
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\t'; }, ' ');
  return line;
}

struct ClearResult {
  void operator()(PGresult* result) const { PQclear(result); }
};
using PgResult = std::unique_ptr<PGresult, ClearResult>;

void hear_notice(void*, const PGresult*) {}

Result<void> refused_by(const PGresult* result) {
  const char* state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  for (const char* const none : kNoSuch)
    if (state != nullptr && std::strcmp(state, none) == 0)
      return fail(Code::kUsage, "this database has no queue of a shop; `tiltfeed shop init` makes one");
  return fail(Code::kInput,
              "the database refuses: " + one_line(PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY)));
}

}  // namespace

struct PgConnection::Pg {
  PGconn* conn = nullptr;
  int stop = -1;
  std::chrono::milliseconds patience = kPatience;
  bool notified = false;

  Pg() = default;
  Pg(const Pg&) = delete;
  Pg& operator=(const Pg&) = delete;
  ~Pg() { PQfinish(conn); }

  tl::unexpected<Error> broken(const std::string& what) const {
    const std::string why = one_line(PQerrorMessage(conn));
    return fail(Code::kLink, what + (why.empty() ? "" : ": " + why));
  }
  Result<void> await(short events, steady_clock::time_point limit) const;
  Result<void> open(const std::string& url);
  Result<void> flush(steady_clock::time_point limit) const;
  Result<PgResult> next(steady_clock::time_point limit);
  void take_notifications();
};

/// Until the socket is ready.
Result<void> PgConnection::Pg::await(short events, steady_clock::time_point limit) const {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(limit - steady_clock::now());
  if (left.count() <= 0) return fail(Code::kLink, "the database does not answer");
  pollfd polled[] = {{PQsocket(conn), events, 0}, {stop, POLLIN, 0}};
  const int ready = ::poll(polled, stop >= 0 ? 2 : 1, static_cast<int>(left.count()) + 1);
  if (stop >= 0 && polled[1].revents != 0) return fail(Code::kCancelled, "ended while it was asked");
  if (ready == 0) return fail(Code::kLink, "the database does not answer");
  return {};
}

Result<void> PgConnection::Pg::open(const std::string& url) {
  std::vector<const char*> keys, values;
  for (const auto& [key, value] : kUsual) keys.push_back(key), values.push_back(value);
  keys.push_back("dbname"), values.push_back(url.c_str());  // the last word is the address's
  keys.push_back(nullptr), values.push_back(nullptr);
  conn = PQconnectStartParams(keys.data(), values.data(), 1);
  if (conn == nullptr) return fail(Code::kLink, "out of memory");
  const auto limit = steady_clock::now() + patience;
  PostgresPollingStatusType status = PGRES_POLLING_WRITING;
  while (status != PGRES_POLLING_OK) {
    if (status == PGRES_POLLING_FAILED || PQstatus(conn) == CONNECTION_BAD) return broken("no connection");
    const auto waited = await(status == PGRES_POLLING_READING ? POLLIN : POLLOUT, limit);
    if (!waited) return waited;
    status = PQconnectPoll(conn);
  }
  PQsetNoticeReceiver(conn, hear_notice, nullptr);
  if (PQsetnonblocking(conn, 1) != 0) return broken("no connection");
  return {};
}

Result<void> PgConnection::Pg::flush(steady_clock::time_point limit) const {
  for (;;) {
    const int left = PQflush(conn);
    if (left < 0) return broken("the connection is lost");
    if (left == 0) return {};
    // The server may have to be heard before it takes more.
    if (const auto waited = await(POLLIN | POLLOUT, limit); !waited) return waited;
    if (PQconsumeInput(conn) == 0) return broken("the connection is lost");
  }
}

/// The next result of the statement; null after the last.
Result<PgResult> PgConnection::Pg::next(steady_clock::time_point limit) {
  while (PQisBusy(conn) != 0) {
    if (const auto waited = await(POLLIN, limit); !waited) return tl::unexpected<Error>(waited.error());
    if (PQconsumeInput(conn) == 0) return broken("the connection is lost");
  }
  return PgResult(PQgetResult(conn));
}

void PgConnection::Pg::take_notifications() {
  while (PGnotify* const heard = PQnotifies(conn)) {
    notified = true;
    PQfreemem(heard);
  }
}

Result<void> check_pg_url(const std::string& url) {
  if (const Result<void> good = config::check_queue_url(url); !good) return good;
  char* why = nullptr;
  PQconninfoOption* const options = PQconninfoParse(url.c_str(), &why);
  PQfreemem(why);  // it may quote the address
  if (options == nullptr)
    return fail(Code::kInput,
                "libpq does not understand the address: postgresql://USER@HOST/DATABASE?NAME=VALUE");
  bool has_password = false;
  for (const PQconninfoOption* one = options; one->keyword != nullptr; ++one)
    has_password = has_password || (one->val != nullptr && std::strstr(one->keyword, "password") != nullptr);
  PQconninfoFree(options);
  if (has_password) return config::check_queue_url("postgresql://u:p@h/");  // says what to do
  return {};
}

PgConnection::PgConnection(std::unique_ptr<Pg> pg) : pg_(std::move(pg)) {}
PgConnection::PgConnection(PgConnection&&) noexcept = default;
PgConnection::~PgConnection() = default;

Result<PgConnection> PgConnection::connect(const std::string& url, int stop,
                                           std::chrono::milliseconds patience) {
  if (const Result<void> good = check_pg_url(url); !good) return tl::unexpected<Error>(good.error());
  auto pg = std::make_unique<Pg>();
  pg->stop = stop;
  pg->patience = patience;
  if (const Result<void> opened = pg->open(url); !opened) return tl::unexpected<Error>(opened.error());
  PgConnection connection(std::move(pg));
  for (std::string limits = kLimits; !limits.empty();) {
    const std::size_t end = std::min(limits.find("; "), limits.size());
    if (const auto set = connection.ask(limits.substr(0, end)); !set)
      return tl::unexpected<Error>(set.error());
    limits.erase(0, std::min(end + 2, limits.size()));
  }
  return connection;
}

bool PgConnection::lost() const { return PQstatus(pg_->conn) != CONNECTION_OK; }

Result<PgRows> PgConnection::ask(const std::string& sql, const std::vector<PgValue>& values) {
  std::vector<const char*> texts;
  std::vector<int> sizes, formats;
  for (const PgValue& value : values) {
    texts.push_back(value.text.c_str());
    sizes.push_back(static_cast<int>(value.text.size()));
    formats.push_back(value.bytes ? 1 : 0);
  }
  const auto limit = steady_clock::now() + pg_->patience;
  if (PQsendQueryParams(pg_->conn, sql.c_str(), static_cast<int>(values.size()), nullptr, texts.data(),
                        sizes.data(), formats.data(), 0) == 0)
    return pg_->broken("the connection is lost");
  if (const auto sent = pg_->flush(limit); !sent) return tl::unexpected<Error>(sent.error());
  PgRows rows;
  Result<void> refused;
  for (;;) {
    const Result<PgResult> result = pg_->next(limit);
    if (!result) return tl::unexpected<Error>(result.error());
    if (!*result) break;
    const PGresult* const one = result->get();
    const ExecStatusType status = PQresultStatus(one);
    if (status != PGRES_TUPLES_OK && status != PGRES_COMMAND_OK) refused = refused_by(one);
    for (int row = 0; row < PQntuples(one); ++row) {
      PgRow& columns = rows.rows.emplace_back();
      for (int column = 0; column < PQnfields(one); ++column)
        columns.emplace_back(PQgetvalue(one, row, column),
                             static_cast<std::size_t>(PQgetlength(one, row, column)));
    }
  }
  pg_->take_notifications();
  // The server says why it ends a connection, and then ends it.
  if (lost()) return pg_->broken("the connection is lost");
  if (!refused) return tl::unexpected<Error>(refused.error());
  return rows;
}

Result<PgRows> PgConnection::last_words(const std::string& sql, const std::vector<PgValue>& values,
                                        std::chrono::milliseconds most) {
  pg_->stop = -1;
  pg_->patience = most;
  return ask(sql, values);
}

Result<void> PgConnection::forget_notifications() {
  if (PQconsumeInput(pg_->conn) == 0) return pg_->broken("the connection is lost");
  pg_->take_notifications();
  pg_->notified = false;
  return {};
}

Result<bool> PgConnection::wait(int wake, std::chrono::milliseconds most) {
  Pg& pg = *pg_;
  const auto limit = steady_clock::now() + most;
  for (;;) {
    if (std::exchange(pg.notified, false)) return true;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(limit - steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd polled[] = {{PQsocket(pg.conn), POLLIN, 0}, {pg.stop, POLLIN, 0}, {wake, POLLIN, 0}};
    if (::poll(polled, 3, static_cast<int>(left.count()) + 1) == 0) return false;
    if (polled[1].revents != 0 || polled[2].revents != 0) return true;
    if (PQconsumeInput(pg.conn) == 0) return pg.broken("the connection is lost");
    pg.take_notifications();
    if (lost()) return pg.broken("the connection is lost");
  }
}

}  // namespace tiltfeed::daemon
