#include "daemon/shop/shop_client.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "daemon/shop/shop_files.h"
#include "daemon/shop/shop_layout.h"

namespace tiltfeed::daemon {

namespace {

/// A machine that is asked for by nobody else takes so many jobs in one turn, and looks at so many pages.
constexpr int kMostTaken = 100, kMostPages = 100, kMostBatches = 1000;

std::optional<std::uint64_t> number_of(const std::string& text) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 62U;
  std::uint64_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size() || value > kMost) return std::nullopt;
  return value;
}

tl::unexpected<Error> not_a_shop(const std::string& what) {
  return fail(Code::kUsage, "the database answers otherwise than a shop's queue does: " + what);
}

std::string id_array(const std::vector<std::string>& ids) {
  std::string text = "{";
  for (const std::string& id : ids) text += (text.size() > 1 ? "," : "") + id;
  return text + "}";
}

/// Controller and database both know it: it moved, or may have.
bool has_begun(const std::string& state) {
  constexpr const char* kBefore[] = {"accepted", "received", "planning", "ready",
                                     "failed",   "spoiled",  "removed",  "overruled"};
  return std::none_of(std::begin(kBefore), std::end(kBefore), [&](const char* one) { return state == one; });
}

}  // namespace

struct ShopClient::Found {
  ShopMark mark;
  std::string halted;
  bool told = false;
};

Result<ShopJob> read_claim(const PgRow& row) {
  constexpr std::size_t kColumns = 10;
  if (row.size() != kColumns || !is_uuid(row[0])) return not_a_shop("a claim");
  const auto epoch = number_of(row[1]), token = number_of(row[2]), number = number_of(row[3]);
  const auto bytes = number_of(row[7]), part_bytes = number_of(row[9]);
  if (!epoch || !token || !number) return not_a_shop("a claim's numbers");
  ShopJob job{{row[0], *epoch, *token}, *number, row[4], row[5] == "t", {}};
  job.files.push_back({row[6], bytes.value_or(0)});
  if (!job.program) job.files.push_back({row[8], part_bytes.value_or(0)});
  std::uint64_t all = 0;
  for (const ShopFile& file : job.files) {
    if (!is_digest(file.sha256)) return fail(Code::kInput, "it has no digest");
    if (file.bytes == 0 || file.bytes > kMostShopBytes)
      return fail(Code::kInput,
                  "a file of it is empty, or larger than " + std::to_string(kMostShopBytes >> 20U) + " MiB");
    all += file.bytes;
  }
  if (all > kMostShopBytes) return fail(Code::kInput, "its files are too large together");
  return job;
}

void ShopClient::show(const std::string& text) {
  if (text != shown_ && ledger_.show) ledger_.show(text);
  shown_ = text;
}

Result<ShopClient::Found> ShopClient::hello(const ShopAsk& ask, const LocalShop& local) {
  const ShopMark& m = local.mark;
  machine_ = local.machine;
  const std::string& name = local.name.empty() ? local.offer.profile : local.name;
  const Result<PgRows> rows = ask(kShopHello, {local.machine, name, offer_json(local.offer), local.status,
                                               m.shop, m.epoch, m.epoch_id, m.token, m.serial, local.live});
  if (!rows) return tl::unexpected<Error>(rows.error());
  constexpr std::size_t kColumns = 8;
  if (rows->rows.size() != 1 || rows->rows[0].size() != kColumns) return not_a_shop("the greeting");
  const PgRow& row = rows->rows[0];
  if (row[0] != std::to_string(kShopLayout))
    return fail(Code::kUsage, "the shop's queue is of layout " + row[0] + ", this tiltfeed knows " +
                                  std::to_string(kShopLayout) +
                                  "; install the same version everywhere, and "
                                  "`tiltfeed shop init` brings an earlier queue up to date");
  const auto epoch = number_of(row[2]), token = number_of(row[4]), serial = number_of(row[5]);
  if (!is_uuid(row[1]) || !is_uuid(row[3]) || !epoch || !token || !serial)
    return not_a_shop("the greeting's numbers");
  return Found{{row[1], *epoch, row[3], *token, *serial}, row[6], row[7] == "t"};
}

/// What the database is to us now, kept; once for each of its states all is told to it again.
Result<void> ShopClient::trust(const Found& found, LocalShop& local) {
  const ShopTrust trust = judge_shop(local.mark, found.mark);
  // More of ours than we know of: a reply was lost, or this spool was put back from a copy.
  const bool ahead = found.mark.serial > local.mark.serial;
  const std::string state = found.mark.epoch_id + (trust == ShopTrust::kRestored ? " restored" : "");
  if ((trust != ShopTrust::kSame || ahead) && (retold_ != state || ahead)) {
    if (Result<void> again = ledger_.retell(); !again) return again;
    Result<LocalShop> now = ledger_.read();
    if (!now) return tl::unexpected<Error>(now.error());
    local = std::move(*now);
    retold_ = state;
  }
  if (trust == ShopTrust::kRestored || found.mark == local.mark) return {};
  return ledger_.remember(found.mark);
}

Result<void> ShopClient::turn(const ShopAsk& ask) {
  Result<LocalShop> local = ledger_.read();
  if (!local) return tl::unexpected<Error>(local.error());
  const Result<Found> found = hello(ask, *local);
  if (!found) return tl::unexpected<Error>(found.error());
  const bool restored = judge_shop(local->mark, found->mark) == ShopTrust::kRestored;
  if (const Result<void> judged = trust(*found, *local); !judged) return judged;
  if (const Result<void> sent = send_reports(ask, *local); !sent) return sent;
  if (const Result<void> sent = send_states(ask, *local); !sent) return sent;
  if (!found->told)
    if (const Result<PgRows> told = ask(kShopTold, {local->machine}); !told)
      return tl::unexpected<Error>(told.error());
  if (restored || !found->halted.empty()) {
    const std::string why =
        found->halted.empty() ? "the database is behind what this machine has seen of it" : found->halted;
    show("halted: " + why.substr(0, 300) +
         "; `tiltfeed shop raise` goes on, when every machine has told its part");
    return {};
  }
  show("connected");
  if (const Result<void> given = give_back(ask, *local); !given) return given;
  for (const ShopJob& job : local->claimed) {
    const Result<bool> ours = accept(ask, local->machine, job);
    if (!ours) return tl::unexpected<Error>(ours.error());
    if (!*ours) continue;
    if (const Result<void> here = bring(ask, job); !here) return here;
  }
  for (const ShopJob& job : local->accepted)
    if (const Result<void> here = bring(ask, job); !here) return here;
  if (Result<void> taken = take_more(ask, *found); !taken) return taken;
  return turn_plans(ask);
}

/// Jobs go on without: who asks plans by itself.
Result<void> ShopClient::turn_plans(const ShopAsk& ask) {
  const Result<void> turned = plans_.turn(ask, machine_);
  if (turned) plan_trouble_.clear();
  if (turned || turned.error().code != Code::kInput) return turned;
  const std::string& trouble = turned.error().message;
  if (trouble != plan_trouble_) ledger_.log(true, "planning for each other in the shop: " + trouble);
  plan_trouble_ = trouble;
  return {};
}

Result<void> ShopClient::give_back(const ShopAsk& ask, const LocalShop& local) {
  if (local.waiting.empty()) return {};
  const Result<PgRows> rows = ask(kShopGone, {id_array(local.waiting), local.machine});
  if (!rows) return tl::unexpected<Error>(rows.error());
  for (const PgRow& row : rows->rows) {
    if (row.size() != 2 ||
        std::find(local.waiting.begin(), local.waiting.end(), row[0]) == local.waiting.end())
      return not_a_shop("a job that is gone");
    if (const Result<void> over = ledger_.overrule(row[0], "it is " + row[1].substr(0, 40) + " there"); !over)
      return over;
  }
  return {};
}

Result<void> ShopClient::send_reports(const ShopAsk& ask, LocalShop& local) {
  for (int batch = 0; batch < kMostBatches && !local.reports.empty(); ++batch) {
    for (const ShopReport& one : local.reports)
      if (const Result<void> sent = report(ask, local.machine, one); !sent) return sent;
    Result<LocalShop> now = ledger_.read();
    if (!now) return tl::unexpected<Error>(now.error());
    local = std::move(*now);
  }
  return {};
}

/// Of machines, not of jobs: they decide nothing, so that a queue that is halted gets them, too.
Result<void> ShopClient::send_states(const ShopAsk& ask, LocalShop& local) {
  for (int batch = 0; batch < kMostBatches && !local.states.empty(); ++batch) {
    std::string times = "{", words = "{";
    for (const ShopState& one : local.states) {
      times += (times.size() > 1 ? "," : "") + std::to_string(one.at);
      words += (words.size() > 1 ? "," : "") + one.state;
    }
    const Result<PgRows> sent = ask(kShopStates, {local.machine, times + "}", words + "}"});
    if (!sent) return tl::unexpected<Error>(sent.error());
    if (Result<void> kept = ledger_.told_states(local.states.back().at); !kept) return kept;
    Result<LocalShop> now = ledger_.read();
    if (!now) return tl::unexpected<Error>(now.error());
    local = std::move(*now);
  }
  return {};
}

Result<void> ShopClient::report(const ShopAsk& ask, const std::string& machine, const ShopReport& one) {
  const ShopTicket& ticket = one.job.ticket;
  const Result<PgRows> rows =
      ask(kShopReport,
          {machine, ticket.job, ticket.epoch, ticket.token, one.version, one.state, one.note, one.blocks,
           one.executed, one.job.name, one.job.program, has_begun(one.state), one.job.files.at(0).sha256});
  if (!rows) return tl::unexpected<Error>(rows.error());
  if (rows->rows.size() != 1 || rows->rows[0].size() != 3) return not_a_shop("a report's answer");
  const PgRow& row = rows->rows[0];
  const auto serial = number_of(row[2]);
  if (row[0] == "taken" && serial) return ledger_.told(ticket.job, one.version, *serial);
  if (row[0] == "overruled") return ledger_.overrule(ticket.job, row[1].substr(0, 300));
  return not_a_shop("a report's verdict");
}

/// False: it came to nothing.
Result<bool> ShopClient::accept(const ShopAsk& ask, const std::string& machine, const ShopJob& job) {
  const Result<PgRows> rows = ask(kShopAccept, {machine, job.ticket.job, job.ticket.epoch, job.ticket.token});
  if (!rows) return tl::unexpected<Error>(rows.error());
  if (rows->rows.size() != 1 || rows->rows[0].size() != 2) return not_a_shop("an acceptance's answer");
  const std::string& verdict = rows->rows[0][0];
  const auto serial = number_of(rows->rows[0][1]);
  Result<void> kept;
  if (verdict == "accepted" && serial)
    kept = ledger_.confirm(job.ticket.job, *serial);
  else if (verdict == "lost")
    kept = ledger_.drop(job.ticket.job);
  else if (verdict != "halted")
    return not_a_shop("an acceptance's verdict");
  if (!kept) return tl::unexpected<Error>(kept.error());
  return verdict == "accepted";
}

Result<void> ShopClient::bring(const ShopAsk& ask, const ShopJob& job) {
  const Result<std::vector<int>> files = fetch_files(ask, job, ledger_.scratch);
  if (!files && files.error().code == Code::kInput)
    return ledger_.spoil(job.ticket.job, files.error().message);
  if (!files) return tl::unexpected<Error>(files.error());
  Result<void> here = ledger_.arrive(job, *files);
  for (const int file : *files) ::close(file);
  if (!here && here.error().code == Code::kInput) return ledger_.spoil(job.ticket.job, here.error().message);
  return here;
}

Result<std::vector<std::string>> ShopClient::fitting(const ShopAsk& ask, const ShopOffer& offer) {
  std::uint64_t after = 0;
  for (int page = 0; page < kMostPages; ++page) {
    const Result<PgRows> rows = ask(kShopOpen, {after});
    if (!rows) return tl::unexpected<Error>(rows.error());
    std::vector<std::string> fits;
    for (const PgRow& row : rows->rows) {
      const auto number = row.size() == 3 ? number_of(row[1]) : std::nullopt;
      if (!number || !is_uuid(row[0])) return not_a_shop("an open job");
      after = std::max(after, *number);
      const Result<ShopNeeds> needs = parse_needs(row[2]);
      if (needs && !misfit(*needs, offer)) fits.push_back(row[0]);
    }
    if (!fits.empty() || rows->rows.size() < kShopPage) return fits;
  }
  return std::vector<std::string>{};
}

/// What of these is still there. Nothing: others were faster, or nothing is given now.
Result<std::optional<ShopJob>> ShopClient::claim(const ShopAsk& ask, const LocalShop& local,
                                                 const Found& found, const std::vector<std::string>& fits) {
  const Result<PgRows> rows =
      ask(kShopClaim, {local.machine, id_array(fits), found.mark.epoch, found.mark.epoch_id});
  if (!rows) return tl::unexpected<Error>(rows.error());
  if (rows->rows.empty()) return std::nullopt;
  const PgRow& row = rows->rows[0];
  Result<ShopJob> job = read_claim(row);
  if (job) return std::move(*job);
  if (job.error().code != Code::kInput) return tl::unexpected<Error>(job.error());
  const std::string why = local.offer.profile + " cannot take it: " + job.error().message;
  ledger_.log(true, "job " + row[3] + " of the shop: " + why);
  const Result<PgRows> held = ask(kShopRefuse, {local.machine, row[0], row[1], row[2], why});
  if (!held) return tl::unexpected<Error>(held.error());
  return std::nullopt;
}

Result<void> ShopClient::take_more(const ShopAsk& ask, const Found& found) {
  for (int taken = 0; taken < kMostTaken; ++taken) {
    const Result<LocalShop> local = ledger_.read();
    if (!local) return tl::unexpected<Error>(local.error());
    room_ = local->wants;
    if (!room_) return {};
    const Result<std::vector<std::string>> fits = fitting(ask, local->offer);
    if (!fits) return tl::unexpected<Error>(fits.error());
    if (fits->empty()) return {};
    const Result<std::optional<ShopJob>> job = claim(ask, *local, found, *fits);
    if (!job) return tl::unexpected<Error>(job.error());
    if (!*job) return {};
    ShopMark mark = local->mark;
    mark.token = std::max(mark.token, (*job)->ticket.token);
    const Result<bool> fresh = ledger_.claim(**job, mark);
    if (!fresh) return tl::unexpected<Error>(fresh.error());
    const Result<bool> ours = accept(ask, local->machine, **job);
    if (!ours) return tl::unexpected<Error>(ours.error());
    // One that is here already is reported in the next turn, with the state that it has here.
    if (!*ours || !*fresh) continue;
    if (const Result<void> here = bring(ask, **job); !here) return here;
  }
  return {};
}

}  // namespace tiltfeed::daemon
