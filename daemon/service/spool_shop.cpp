#include "daemon/service/spool_shop.h"

#include <sqlite3.h>

#include "daemon/service/spool.h"
#include "daemon/service/spool_table.h"
#include "daemon/wire/wire_text.h"

namespace tiltfeed::daemon {

namespace {

constexpr const char* kShopColumns =
    "uuid, epoch, token, number, name, program, hash, bytes, part_hash, part_bytes, changed, state, note, "
    "blocks, executed";

ShopReport report_of(const SpoolStatement& row) {
  ShopReport one;
  one.job.ticket = {row.text(0), row.number(1), row.number(2)};
  one.job.number = row.number(3);
  one.job.name = row.text(4);
  one.job.program = row.number(5) != 0;
  one.job.files.push_back({row.text(6), row.number(7)});
  if (!one.job.program) one.job.files.push_back({row.text(8), row.number(9)});
  one.version = row.number(10);
  one.state = row.text(11);
  one.note = valid_text(row.text(12));
  one.blocks = row.number(13);
  one.executed = row.number(14);
  return one;
}

}  // namespace

SpoolShop Spool::shop() const { return SpoolShop(*table_, folder_); }

Result<std::optional<SpooledJob>> Spool::find_shop(const std::string& id) const {
  std::uint64_t number = 0;
  {
    SpoolStatement row;
    if (!table_->prepare(row, "SELECT id FROM jobs WHERE shop <> '' AND shop = ?"))
      return tl::unexpected<Error>(table_->error(folder_));
    row.bind(1, id);
    const int step = sqlite3_step(row.s);
    if (step == SQLITE_DONE) return std::nullopt;
    if (step != SQLITE_ROW) return tl::unexpected<Error>(table_->error(folder_));
    number = row.number(0);
  }
  Result<SpooledJob> job = find(number);
  if (!job) return tl::unexpected<Error>(job.error());
  return std::move(*job);
}

Result<void> SpoolShop::transaction(const std::function<Result<void>()>& work) {
  if (sqlite3_exec(table_.db, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr) != SQLITE_OK)
    return tl::unexpected<Error>(table_.error(folder_));
  Result<void> done = work();
  if (done && sqlite3_exec(table_.db, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK)
    done = tl::unexpected<Error>(table_.error(folder_));
  if (!done) sqlite3_exec(table_.db, "ROLLBACK", nullptr, nullptr, nullptr);
  return done;
}

Result<std::vector<ShopReport>> SpoolShop::select(const std::string& which) {
  SpoolStatement rows;
  if (!table_.prepare(rows, std::string("SELECT ") + kShopColumns + " FROM shop_jobs " + which))
    return tl::unexpected<Error>(table_.error(folder_));
  std::vector<ShopReport> found;
  int step = 0;
  while ((step = sqlite3_step(rows.s)) == SQLITE_ROW) found.push_back(report_of(rows));
  if (step != SQLITE_DONE) return tl::unexpected<Error>(table_.error(folder_));
  return found;
}

Result<LocalShop> SpoolShop::read(int ahead) {
  LocalShop local;
  for (int look = 0; look < 2 && local.machine.empty(); ++look) {
    SpoolStatement self;
    if (!table_.prepare(self, "SELECT machine, shop, epoch, epoch_id, token, serial FROM shop_self"))
      return tl::unexpected<Error>(table_.error(folder_));
    const int step = sqlite3_step(self.s);
    if (step == SQLITE_ROW) {
      local.machine = self.text(0);
      local.mark = {self.text(1), self.number(2), self.text(3), self.number(4), self.number(5)};
      break;
    }
    sqlite3_reset(self.s);  // a reading that is still open would let no writer wait for its turn
    if (step != SQLITE_DONE || !table_.run("INSERT INTO shop_self (one, machine) VALUES (1, ?)", make_uuid()))
      return tl::unexpected<Error>(table_.error(folder_));
  }
  constexpr const char* kWaiting = "WHERE state IN ('claimed', 'accepted', 'received', 'planning', 'ready')";
  const auto waiting = select(kWaiting), reports = select("WHERE changed > told ORDER BY rowid LIMIT 100");
  if (!waiting) return tl::unexpected<Error>(waiting.error());
  if (!reports) return tl::unexpected<Error>(reports.error());
  for (const ShopReport& one : *waiting) {
    if (one.state == "claimed")
      local.claimed.push_back(one.job);
    else if (one.state == "accepted")
      local.accepted.push_back(one.job);
    else
      local.waiting.push_back(one.job.ticket.job);
  }
  local.reports = *reports;
  local.wants = waiting->size() < static_cast<std::size_t>(ahead);
  return local;
}

Result<void> SpoolShop::remember(const ShopMark& mark) {
  if (table_.run("UPDATE shop_self SET shop = ?, epoch = ?, epoch_id = ?, token = ?, serial = ?", mark.shop,
                 mark.epoch, mark.epoch_id, mark.token, mark.serial))
    return {};
  return tl::unexpected<Error>(table_.error(folder_));
}

Result<void> SpoolShop::insert(const ShopJob& job) {
  const ShopFile part = job.files.size() > 1 ? job.files[1] : ShopFile();
  if (table_.run(
          "INSERT INTO shop_jobs (uuid, epoch, token, number, name, program, hash, bytes, part_hash, "
          "part_bytes, "
          "state) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'claimed') ON CONFLICT (uuid) DO UPDATE SET epoch = "
          "excluded.epoch, token = excluded.token, state = 'claimed', note = ''",
          job.ticket.job, job.ticket.epoch, job.ticket.token, job.number, plain_name(job.name),
          std::uint64_t{job.program}, job.files.at(0).sha256, job.files.at(0).bytes, part.sha256, part.bytes))
    return {};
  return tl::unexpected<Error>(table_.error(folder_));
}

Result<bool> SpoolShop::claim(const ShopJob& job, const ShopMark& mark) {
  const Result<std::string> before = state(job.ticket.job);
  if (!before) return tl::unexpected<Error>(before.error());
  const bool fresh = before->empty() || *before == "dropped" || *before == "claimed" || *before == "spoiled";
  const Result<void> kept = transaction([&]() -> Result<void> {
    if (Result<void> marked = remember(mark); !marked) return marked;
    if (fresh) return insert(job);
    if (table_.run("UPDATE shop_jobs SET epoch = ?, token = ?, changed = changed + 1 WHERE uuid = ?",
                   job.ticket.epoch, job.ticket.token, job.ticket.job))
      return {};
    return tl::unexpected<Error>(table_.error(folder_));
  });
  if (!kept) return tl::unexpected<Error>(kept.error());
  return fresh;
}

Result<void> SpoolShop::raise_serial(std::uint64_t serial) {
  if (table_.run("UPDATE shop_self SET serial = max(serial, ?)", serial)) return {};
  return tl::unexpected<Error>(table_.error(folder_));
}

Result<void> SpoolShop::confirm(const std::string& job, std::uint64_t serial) {
  return transaction([&]() -> Result<void> {
    if (!table_.run(
            "UPDATE shop_jobs SET state = 'accepted', changed = changed + 1, told = changed + 1 WHERE "
            "uuid = ? "
            "AND state = 'claimed'",
            job))
      return tl::unexpected<Error>(table_.error(folder_));
    return raise_serial(serial);
  });
}

Result<void> SpoolShop::drop(const std::string& job) {
  if (table_.run("UPDATE shop_jobs SET state = 'dropped' WHERE uuid = ? AND state = 'claimed'", job))
    return {};
  return tl::unexpected<Error>(table_.error(folder_));
}

Result<void> SpoolShop::spoil(const std::string& job, const std::string& why) {
  if (table_.run("UPDATE shop_jobs SET state = 'spoiled', note = ?, changed = changed + 1 WHERE uuid = ? AND "
                 "state = "
                 "'accepted'",
                 valid_text(why), job))
    return {};
  return tl::unexpected<Error>(table_.error(folder_));
}

Result<void> SpoolShop::told(const std::string& job, std::uint64_t version, std::uint64_t serial) {
  return transaction([&]() -> Result<void> {
    if (!table_.run("UPDATE shop_jobs SET told = max(told, ?) WHERE uuid = ?", version, job))
      return tl::unexpected<Error>(table_.error(folder_));
    return raise_serial(serial);
  });
}

Result<void> SpoolShop::overrule(const std::string& job) {
  if (table_.run("UPDATE shop_jobs SET state = 'overruled', told = changed WHERE uuid = ?", job)) return {};
  return tl::unexpected<Error>(table_.error(folder_));
}

Result<void> SpoolShop::retell() {
  if (table_.run("UPDATE shop_jobs SET told = 0 WHERE state NOT IN ('claimed', 'dropped', 'overruled')"))
    return {};
  return tl::unexpected<Error>(table_.error(folder_));
}

Result<std::string> SpoolShop::state(const std::string& job) {
  SpoolStatement row;
  if (!table_.prepare(row, "SELECT state FROM shop_jobs WHERE uuid = ?"))
    return tl::unexpected<Error>(table_.error(folder_));
  row.bind(1, job);
  const int step = sqlite3_step(row.s);
  if (step == SQLITE_ROW) return row.text(0);
  if (step == SQLITE_DONE) return std::string();
  return tl::unexpected<Error>(table_.error(folder_));
}

bool SpoolShop::has_news() {
  SpoolStatement row;
  return table_.prepare(row, "SELECT 1 FROM shop_jobs WHERE changed > told LIMIT 1") &&
         sqlite3_step(row.s) == SQLITE_ROW;
}

}  // namespace tiltfeed::daemon
