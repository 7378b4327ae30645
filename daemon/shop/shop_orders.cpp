#include "daemon/shop/shop_orders.h"

#include <algorithm>
#include <cstdlib>

#include "daemon/shop/shop_files.h"
#include "daemon/shop/shop_layout.h"

namespace tiltfeed::daemon {

namespace {

constexpr const char* kMachines =
    "SELECT m.id, left(m.name, 100), left(m.offer, 8193), left(m.status, 200), extract(epoch FROM now() - "
    "m.seen), m.away OR (m.told AND m.incarnation = s.incarnation), m.away, extract(epoch FROM "
    "m.seen)::bigint, left(m.live, 3001) FROM tiltfeed.machines m, tiltfeed.shop s ORDER BY m.name, m.id "
    "LIMIT 1000";
/// $1: ended ones, too; $2: those of the last day.
constexpr const char* kEntries =
    "SELECT j.number, j.id, left(j.name, 100), j.program, left(j.needs, 8193), left(j.state, 40), "
    "left(j.note, 300), coalesce(left(m.name, 100), ''), j.blocks, j.executed, extract(epoch FROM "
    "j.submitted)::bigint, extract(epoch FROM j.changed)::bigint FROM tiltfeed.jobs j LEFT JOIN "
    "tiltfeed.machines m ON m.id = j.machine WHERE $1 OR j.state NOT IN ('done', 'withdrawn') OR ($2 AND "
    "j.changed > now() - interval '1 day') ORDER BY $2 AND j.state IN ('done', 'withdrawn'), j.number DESC "
    "LIMIT 1000";

std::uint64_t count_of(const std::string& text) { return std::strtoull(text.c_str(), nullptr, 10); }

Result<std::string> one_value(const Result<PgRows>& rows) {
  if (!rows) return tl::unexpected<Error>(rows.error());
  if (rows->rows.size() != 1 || rows->rows[0].empty())
    return fail(Code::kUsage, "the database answers otherwise than a shop's queue does");
  return rows->rows[0][0];
}

}  // namespace

Result<bool> init_shop(const ShopAsk& ask) {
  const Result<std::string> there =
      one_value(ask("SELECT count(*) FROM pg_namespace WHERE nspname = 'tiltfeed'", {}));
  if (!there) return tl::unexpected<Error>(there.error());
  const bool fresh = *there == "0";
  std::vector<std::string> statements = shop_layout();
  const Result<void> made = in_one_transaction(ask, [&]() -> Result<void> {
    if (!fresh) {
      const Result<std::string> layout = one_value(ask("SELECT layout FROM tiltfeed.shop FOR UPDATE", {}));
      if (!layout) return tl::unexpected<Error>(layout.error());
      statements = shop_upgrade(*layout);
      if (statements.empty())
        return fail(Code::kUsage, "this database has the schema tiltfeed already, of layout " + *layout);
    }
    for (const std::string& statement : statements)
      if (const auto done = ask(statement, {}); !done) return tl::unexpected<Error>(done.error());
    return {};
  });
  if (!made) return tl::unexpected<Error>(made.error());
  return fresh;
}

void judge_fit(const ShopNeeds& needs, const std::vector<ShopMachine>& machines, ShopEntry& entry) {
  entry.fits_one = false;
  for (const ShopMachine& machine : machines) {
    const auto why = misfit(needs, machine.offer);
    if (!why) entry.fits_one = true;
    if (why) entry.why_not += (entry.why_not.empty() ? "" : "; ") + machine.name + ": " + *why;
  }
  if (machines.empty()) entry.why_not = "no machine has been here yet";
  if (entry.fits_one) entry.why_not.clear();
}

Result<ShopView> view_shop(const ShopAsk& ask, ShopPick pick) {
  ShopView view;
  const auto shop =
      ask("SELECT epoch, extract(epoch FROM now())::bigint, left(halted, 300) FROM tiltfeed.shop", {});
  if (const auto epoch = one_value(shop); !epoch) return tl::unexpected<Error>(epoch.error());
  view.epoch = count_of(shop->rows[0][0]);
  view.now = static_cast<std::int64_t>(count_of(shop->rows[0].at(1)));
  view.halted = shop->rows[0].back();
  const auto machines = ask(kMachines, {});
  if (!machines) return tl::unexpected<Error>(machines.error());
  for (const PgRow& row : machines->rows) {
    ShopMachine machine;
    machine.id = row[0], machine.name = row[1], machine.status = row[3];
    machine.silent_seconds = std::strtod(row[4].c_str(), nullptr);
    machine.back = row[5] == "t", machine.away = row[6] == "t";
    machine.seen = static_cast<std::int64_t>(count_of(row[7]));
    machine.live = parse_live(row[8]);
    if (auto offer = parse_offer(row[2])) machine.offer = std::move(*offer);
    view.machines.push_back(std::move(machine));
  }
  const auto jobs = ask(kEntries, {pick == ShopPick::kAll, pick == ShopPick::kLastDay});
  if (!jobs) return tl::unexpected<Error>(jobs.error());
  for (const PgRow& row : jobs->rows) {
    ShopEntry entry{count_of(row[0]),
                    row[1],
                    row[2],
                    row[5],
                    row[6],
                    row[7],
                    row[3] == "t",
                    "",
                    count_of(row[8]),
                    count_of(row[9]),
                    static_cast<std::int64_t>(count_of(row[10])),
                    static_cast<std::int64_t>(count_of(row[11])),
                    true,
                    ""};
    const Result<ShopNeeds> needs = parse_needs(row[4]);
    entry.needs = needs ? needs_text(*needs) : needs.error().message;
    if (entry.state == "open" && needs) judge_fit(*needs, view.machines, entry);
    if (entry.state == "open" && !needs) entry.fits_one = false, entry.why_not = needs.error().message;
    view.jobs.push_back(std::move(entry));
  }
  auto plans = view_plans(ask);
  if (!plans) return tl::unexpected<Error>(plans.error());
  view.plans = std::move(*plans);
  return view;
}

Result<std::string> take_back(const ShopAsk& ask, std::uint64_t number, bool open) {
  std::string said;
  const Result<void> done = in_one_transaction(ask, [&]() -> Result<void> {
    const auto rows =
        ask("SELECT j.state, coalesce(m.name, ''), EXISTS (SELECT 1 FROM tiltfeed.pieces p WHERE p.job = "
            "j.id) FROM "
            "tiltfeed.jobs j LEFT JOIN tiltfeed.machines m ON m.id = j.machine WHERE j.number = $1 FOR "
            "UPDATE OF j",
            {number});
    if (!rows) return tl::unexpected<Error>(rows.error());
    const std::string name = "job " + std::to_string(number) + " of the shop";
    if (rows->rows.empty()) return fail(Code::kUsage, "there is no " + name);
    const std::string &state = rows->rows[0][0], &machine = rows->rows[0][1];
    constexpr const char* kBefore[] = {"open",   "claimed", "accepted", "received",  "planning", "ready",
                                       "failed", "spoiled", "removed",  "overruled", "held",     "withdrawn"};
    if (std::none_of(std::begin(kBefore), std::end(kBefore), [&](const char* one) { return state == one; }))
      return fail(Code::kUsage,
                  name + " is " + state + " at " + machine +
                      ": it has begun, and is that machine's; submit what is left as a job of its own");
    if (open && rows->rows[0][2] != "t")
      return fail(Code::kUsage, name + " has no files in this database any more; submit it again");
    // A ticket of its own: what a machine still says of it by an older one does not count.
    const auto given = ask("UPDATE tiltfeed.shop SET token = token + 1 RETURNING epoch, token", {});
    if (!given) return tl::unexpected<Error>(given.error());
    if (const auto ticket = one_value(given); !ticket) return tl::unexpected<Error>(ticket.error());
    const auto changed =
        ask("UPDATE tiltfeed.jobs SET state = $2, machine = NULL, epoch = $3, token = $4, version = 0, lease "
            "= NULL, note "
            "= $5, changed = now() WHERE number = $1",
            {number, open ? "open" : "withdrawn", given->rows[0][0], given->rows[0][1],
             machine.empty() ? std::string() : "it was " + state + " at " + machine});
    if (!changed) return tl::unexpected<Error>(changed.error());
    said = name + (open ? " is open again" : " is withdrawn") +
           (machine.empty() ? "" : "; " + machine + " gives it up when it hears of it: look there first");
    const auto told = ask(kShopNotify, {});
    return told ? Result<void>() : tl::unexpected<Error>(told.error());
  });
  if (!done) return tl::unexpected<Error>(done.error());
  return said;
}

Result<std::uint64_t> raise_epoch(const ShopAsk& ask) {
  const Result<std::string> epoch = one_value(ask(
      "UPDATE tiltfeed.shop SET epoch = epoch + 1, epoch_id = gen_random_uuid(), halted = '' RETURNING epoch",
      {}));
  if (!epoch) return tl::unexpected<Error>(epoch.error());
  static_cast<void>(ask(kShopNotify, {}));
  return count_of(*epoch);
}

}  // namespace tiltfeed::daemon
