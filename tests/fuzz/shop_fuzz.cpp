// What anybody with a password of the shop's database may have written there: needs of a job, what a machine
// has and is at, a claim, orders of planning. The first byte says which.

#include "daemon/shop/shop_client.h"

#include <cmath>

#include "daemon/shop/shop_fit.h"
#include "daemon/shop/shop_live.h"
#include "daemon/shop/shop_plan_layout.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::daemon;

namespace {

void read_needs(const std::string& text) {
  const auto needs = parse_needs(text);
  const auto offer = parse_offer(text);
  HOLDS(needs.has_value() == offer.has_value());
  if (!needs) return HOLDS(needs.error().code == Code::kInput && !needs.error().message.empty());
  HOLDS(needs->tools.size() <= kMostShopTools && needs->travels.size() <= kMostShopAxes);
  HOLDS(parse_needs(needs_json(*needs)) == *needs);
  HOLDS(parse_offer(offer_json(*offer)) == *offer);
  // Whoever has what is needed fits, and nothing is needed by nobody.
  HOLDS(!misfit(*needs, *offer));
  HOLDS(!misfit({}, *offer));
  HOLDS(!needs_text(*needs).empty());
}

void read_live(const std::string& text) {
  const ShopLive live = parse_live(text);
  HOLDS(is_shop_state(live.state));
  const std::string written = live_json(live);
  HOLDS(written.size() <= kMostLiveJson);
  ShopLive whole = live;
  if (whole.blocks == 0) whole.executed = 0;  // told together
  if (whole.remaining_seconds >= 0.0 && whole.remaining_seconds < 1e15)
    whole.remaining_seconds = std::round(whole.remaining_seconds);
  HOLDS(parse_live(written) == whole);
}

void read_row(const std::string& text) {
  PgRow row(1);
  for (const char c : text) {
    if (c == '\n')
      row.emplace_back();
    else
      row.back().push_back(c);
  }
  const auto job = read_claim(row);
  if (!job) return HOLDS(job.error().code == Code::kInput || job.error().code == Code::kUsage);
  HOLDS(is_uuid(job->ticket.job) && job->files.size() == (job->program ? 1u : 2u));
  std::uint64_t all = 0;
  for (const ShopFile& file : job->files) {
    HOLDS(file.bytes > 0 && file.sha256.size() == 64);
    all += file.bytes;
  }
  HOLDS(all <= kMostShopBytes);
}

/// Answers of a database about orders of planning: columns end at a tab, rows at a line's end, answers at a
/// form feed. Nothing was sent, so nothing that comes back is taken.
void read_plans(const std::string& text) {
  std::vector<PgRows> answers(1);
  answers.back().rows.emplace_back(1);
  for (const char c : text) {
    if (c == '\f')
      answers.emplace_back().rows.emplace_back(1);
    else if (c == '\n')
      answers.back().rows.emplace_back(1);
    else if (c == '\t')
      answers.back().rows.back().emplace_back();
    else
      answers.back().rows.back().back().push_back(c);
  }
  std::size_t asked = 0;
  const ShopAsk ask = [&](const std::string& sql, const std::vector<PgValue>&) -> Result<PgRows> {
    if (sql == kPlanIdle) return PgRows();  // nothing but its rows is looked at
    return asked < answers.size() ? answers[asked++] : PgRows();
  };
  const std::string id = "00000000-0000-4000-8000-000000000001";
  PlanLedger ledger;
  ledger.read = [&]() -> Result<LocalPlans> {
    return LocalPlans{"1", true, {{id, "part", {"/none", "/none", "/none"}}}, std::nullopt};
  };
  ledger.told = [&](const std::string& about, const PlanStanding& standing) -> Result<void> {
    HOLDS(about == id && standing.percent >= 0 && standing.percent <= 100);
    HOLDS(standing.helper.size() <= 100 && standing.stage.size() <= 100 && standing.note.size() <= 700);
    return {};
  };
  ledger.helpers = [](bool) { return Result<void>(); };
  ledger.returned = [](const std::string&, const std::string&, const std::string&,
                       const std::vector<int>&) -> Result<void> {
    HOLDS(false);
    return {};
  };
  ledger.take = [](const PlanTaken& order, const std::vector<int>& files) -> Result<bool> {
    HOLDS(is_uuid(order.id) && files.size() == kPlanInputs && order.name.size() <= 100);
    return false;
  };
  ledger.settled = [](const std::string&) { return Result<void>(); };
  ShopPlans plans(ledger, [] { return -1; });
  const auto turned = plans.turn(ask, id);
  HOLDS(turned || turned.error().code == Code::kUsage || turned.error().code == Code::kIo);
}

}  // namespace

FUZZ_TARGET(shop) {
  if (bytes.empty()) return;
  const std::string text(bytes.substr(1));
  if (bytes[0] == 'l')
    read_live(text);
  else if (bytes[0] == 'c')
    read_row(text);
  else if (bytes[0] == 'p')
    read_plans(text);
  else
    read_needs(text);
}
