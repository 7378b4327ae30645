#include "daemon/shop/shop_plans.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>

#include "daemon/shop/shop_files.h"
#include "daemon/shop/shop_layout.h"
#include "daemon/shop/shop_plan_layout.h"

namespace tiltfeed::daemon {

namespace {

tl::unexpected<Error> not_plans(const std::string& what) {
  return fail(Code::kUsage, "the database answers otherwise than a shop's queue does: " + what);
}

std::optional<std::uint64_t> whole_number(const std::string& text) {
  std::uint64_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Open files that are closed here.
class OpenFiles {
 public:
  OpenFiles() = default;
  explicit OpenFiles(std::vector<int> files) : files_(std::move(files)) {}
  OpenFiles(const OpenFiles&) = delete;
  OpenFiles& operator=(const OpenFiles&) = delete;
  ~OpenFiles() {
    for (const int file : files_)
      if (file >= 0) ::close(file);
  }
  int add(int file) { return files_.push_back(file), file; }
  const std::vector<int>& all() const { return files_; }
  std::vector<int> release() { return std::exchange(files_, {}); }

 private:
  std::vector<int> files_;
};

Result<int> open_given(OpenFiles& files, const std::string& path) {
  const int file = files.add(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file < 0) return fail(Code::kInput, path + ": " + std::strerror(errno));
  return file;
}

/// The digests of all files of one order, in their order.
void add_digest(std::string& all, const ShopFile& file) { all += (all.empty() ? "" : " ") + file.sha256; }

std::optional<PlanState> plan_state(const std::string& word) {
  constexpr std::pair<const char*, PlanState> kWords[] = {{"open", PlanState::kOpen},
                                                          {"taken", PlanState::kTaken},
                                                          {"done", PlanState::kDone},
                                                          {"failed", PlanState::kFailed}};
  for (const auto& [name, state] : kWords)
    if (word == name) return state;
  return std::nullopt;
}

/// Without control characters; cut off between letters.
std::string shown(const std::string& text, std::size_t most) {
  std::size_t end = std::min(text.size(), most);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  std::string kept;
  for (const char c : text.substr(0, end)) kept += static_cast<unsigned char>(c) < ' ' || c == 0x7F ? '?' : c;
  return kept;
}

/// Each so many turns: what a database that was put back may lack or have too much of.
constexpr unsigned kLookEvery = 10;
constexpr std::size_t kLongestName = 100, kLongestStage = 100, kLongestNote = 500;

}  // namespace

Result<void> ShopPlans::turn(const ShopAsk& ask, const std::string& machine) {
  if (!ledger_.read) return {};
  Result<LocalPlans> local = ledger_.read();
  if (!local) return tl::unexpected<Error>(local.error());
  if (looks_ == 0 && !local->help)
    if (const auto back = ask(kPlanBackAll, {machine}); !back) return tl::unexpected<Error>(back.error());
  if (Result<void> seen = look_after(ask, machine, *local); !seen) return seen;
  if (local->help) {
    if (Result<void> helped = help(ask, machine, *local->help, local->version); !helped) return helped;
    local = ledger_.read();
    if (!local) return tl::unexpected<Error>(local.error());
  }
  const bool seldom = looks_ % kLookEvery == 1;
  if (local->offers != offered_ || (seldom && offered_)) {
    const auto told = ask(kPlanOffer, {machine, local->offers ? local->version : std::string()});
    if (!told) return tl::unexpected<Error>(told.error());
    offered_ = local->offers;
  }
  if (!offered_ || local->help) return {};
  if (seldom)
    if (const auto gone = ask(kPlanForget, {}); !gone) return tl::unexpected<Error>(gone.error());
  return take(ask, machine, local->version);
}

// ---- who asks --------------------------------------------------------------------------------------------

Result<void> ShopPlans::look_after(const ShopAsk& ask, const std::string& machine, const LocalPlans& local) {
  if (looks_++ % kLookEvery != 0 && local.asks.empty() && sent_.empty()) return {};
  // Before the orders are seen: who takes one between the two is no more idle, and has it.
  bool idle = false;
  if (!local.asks.empty()) {
    const auto found = ask(kPlanIdle, {machine, local.version});
    if (!found) return tl::unexpected<Error>(found.error());
    idle = !found->rows.empty();
  }
  const auto rows = ask(kPlanSeen, {machine});
  if (!rows) return tl::unexpected<Error>(rows.error());
  std::vector<std::string> there;
  for (const PgRow& row : rows->rows) {
    constexpr std::size_t kColumns = 9;
    if (row.size() != kColumns || !is_uuid(row[0])) return not_plans("an order of planning");
    if (Result<void> heard = hear(ask, row, local); !heard) return heard;
    const bool wanted = std::any_of(local.asks.begin(), local.asks.end(),
                                    [&](const PlanAsk& one) { return one.id == row[0]; });
    if (wanted) there.push_back(row[0]);
    if (wanted) continue;
    if (const auto gone = ask(kPlanDrop, {row[0], machine}); !gone)
      return tl::unexpected<Error>(gone.error());
    sent_.erase(row[0]);
  }
  std::erase_if(sent_, [&](const auto& one) {
    return std::none_of(local.asks.begin(), local.asks.end(),
                        [&](const PlanAsk& order) { return order.id == one.first; });
  });
  if (!local.asks.empty())
    if (Result<void> told = ledger_.helpers(idle); !told) return told;
  for (const PlanAsk& order : local.asks) {
    if (std::find(there.begin(), there.end(), order.id) != there.end()) continue;
    const auto helpers = ask(kPlanHelpers, {machine, local.version});
    if (!helpers) return tl::unexpected<Error>(helpers.error());
    if (helpers->rows.empty()) return {};
    if (Result<void> given = put(ask, machine, local, order); !given) return given;
  }
  return {};
}

Result<void> ShopPlans::put(const ShopAsk& ask, const std::string& machine, const LocalPlans& local,
                            const PlanAsk& order) {
  OpenFiles files;
  std::string digests;
  Result<void> put = in_one_transaction(ask, [&]() -> Result<void> {
    const auto fresh = ask(kPlanAsk, {order.id, machine, order.name, local.version});
    if (!fresh) return tl::unexpected<Error>(fresh.error());
    std::uint64_t all = 0;
    for (std::size_t index = 0; index < kPlanInputs; ++index) {
      const Result<int> file = open_given(files, order.files[index]);
      if (!file) return tl::unexpected<Error>(file.error());
      const Result<ShopFile> about = read_digest(*file);
      if (!about) return tl::unexpected<Error>(about.error());
      add_digest(digests, *about);
      all += about->bytes;
      if (all > kMostShopBytes) return fail(Code::kInput, "its files are too large together");
      if (fresh->rows.empty()) continue;
      const auto row = ask(kPlanGiveFile, {order.id, std::uint64_t{index}, about->sha256, about->bytes});
      if (!row) return tl::unexpected<Error>(row.error());
      std::uint64_t piece = 0;
      const Result<ShopFile> sent = read_pieces(*file, [&](const std::string& bytes) -> Result<void> {
        const auto kept = ask(kPlanGivePiece, {order.id, std::uint64_t{index}, piece++, {bytes, true}});
        return kept ? Result<void>() : tl::unexpected<Error>(kept.error());
      });
      if (!sent) return tl::unexpected<Error>(sent.error());
      if (!(*sent == *about)) return fail(Code::kInput, "a file of it changed while it was read");
    }
    const auto told = ask(kShopNotify, {});
    return told ? Result<void>() : tl::unexpected<Error>(told.error());
  });
  if (put) sent_[order.id] = digests;
  if (put || put.error().code != Code::kInput) return put;
  return ledger_.told(order.id, {PlanState::kFailed, "", 0, "", put.error().message});
}

/// How it stands, or what came of it, to the service.
Result<void> ShopPlans::hear(const ShopAsk& ask, const PgRow& row, const LocalPlans& local) {
  const bool wanted =
      std::any_of(local.asks.begin(), local.asks.end(), [&](const PlanAsk& one) { return one.id == row[0]; });
  if (!wanted) return {};
  const auto state = plan_state(row[1]);
  const auto percent = whole_number(row[4]);
  if (!state || !percent || *percent > 100) return not_plans("the state of an order of planning");
  if (*state == PlanState::kDone) return bring_back(ask, row, local);
  return ledger_.told(row[0], {*state, shown(row[2], kLongestName), static_cast<int>(*percent),
                               shown(row[5], kLongestStage), shown(row[6], kLongestNote)});
}

Result<void> ShopPlans::bring_back(const ShopAsk& ask, const PgRow& row, const LocalPlans& local) {
  const std::string helper = shown(row[2], kLongestName);
  const auto failed = [&](const std::string& why) {
    return ledger_.told(row[0], {PlanState::kFailed, helper, 0, "", why});
  };
  const auto token = whole_number(row[3]);
  if (!token) return not_plans("the token of an order of planning");
  if (row[7] != local.version)
    return failed("it was planned by version " + shown(row[7], kLongestName) + ", this is " + local.version);
  const auto sent = sent_.find(row[0]);
  if (sent == sent_.end() || row[8] != sent->second) return failed("it was planned from other files");
  Result<std::vector<int>> fetched = fetch(ask, row[0], *token, kPlanInputs, kPlanOutputs, nullptr);
  if (!fetched && fetched.error().code == Code::kInput) return failed(fetched.error().message);
  if (!fetched) return tl::unexpected<Error>(fetched.error());
  const OpenFiles files(std::move(*fetched));
  for (const int file : files.all())
    if (::fsync(file) != 0)
      return fail(Code::kIo, std::string("the spool takes no plan: ") + std::strerror(errno));
  return ledger_.returned(row[0], helper, sent->second, files.all());
}

/// Open, at their beginning, as their rows say.
Result<std::vector<int>> ShopPlans::fetch(const ShopAsk& ask, const std::string& id, std::uint64_t token,
                                          std::size_t first, std::size_t count, std::string* from) {
  const auto rows = ask(kPlanFiles, {id, token});
  if (!rows) return tl::unexpected<Error>(rows.error());
  OpenFiles files;
  std::uint64_t all = 0;
  if (rows->rows.size() != count) return fail(Code::kInput, "a file of it is missing");
  for (std::size_t index = 0; index < count; ++index) {
    const PgRow& row = rows->rows[index];
    const std::uint64_t number = first + index;
    if (row.size() != 3 || row[0] != std::to_string(number)) return fail(Code::kInput, "a file is missing");
    const ShopFile wanted{row[1], whole_number(row[2]).value_or(0)};
    all += wanted.bytes;
    if (!is_digest(wanted.sha256) || wanted.bytes == 0 || all > kMostShopBytes)
      return fail(Code::kInput, "a file of it has no digest, is empty or too large");
    const int into = files.add(scratch_());
    if (into < 0) return fail(Code::kIo, std::string("the spool takes no plan: ") + std::strerror(errno));
    const Result<void> fetched = fetch_pieces(
        wanted,
        [&](std::uint64_t piece) {
          return ask(kPlanPiece, {id, token, number, piece});
        },
        into);
    if (!fetched) return tl::unexpected<Error>(fetched.error());
    if (from != nullptr) add_digest(*from, wanted);
  }
  return files.release();
}

// ---- who helps -------------------------------------------------------------------------------------------

Result<void> ShopPlans::help(const ShopAsk& ask, const std::string& machine, const PlanHelp& help,
                             const std::string& version) {
  const PlanTaken& order = help.order;
  Result<PgRows> told;
  switch (help.state) {
    case HelpState::kPlanning:
      told = ask(kPlanKeep, {machine, order.id, order.token, std::to_string(help.percent), help.stage});
      if (!told) return tl::unexpected<Error>(told.error());
      return told->rows.empty() ? ledger_.settled(order.id) : Result<void>();
    case HelpState::kDone:
      if (Result<void> given = give(ask, machine, help, version); !given) return given;
      break;
    case HelpState::kFailed:
      told = ask(kPlanFail, {machine, order.id, order.token, shown(help.note, kLongestNote)});
      break;
    case HelpState::kGivenBack:
      told = ask(kPlanBack, {machine, order.id, order.token});
      break;
  }
  if (!told) return tl::unexpected<Error>(told.error());
  if (const auto heard = ask(kShopNotify, {}); !heard) return tl::unexpected<Error>(heard.error());
  return ledger_.settled(order.id);
}

/// Its files; where they are too large or the order is another's, it has failed or is nobody's here.
Result<void> ShopPlans::give(const ShopAsk& ask, const std::string& machine, const PlanHelp& help,
                             const std::string& version) {
  const PlanTaken& order = help.order;
  OpenFiles files;
  bool mine = true;
  const auto give_all = [&]() -> Result<void> {
    if (const auto gone = ask(kPlanUnmade, {machine, order.id, order.token}); !gone)
      return tl::unexpected<Error>(gone.error());
    std::uint64_t all = 0;
    for (std::size_t index = 0; index < kPlanOutputs && mine; ++index) {
      const std::uint64_t number = kPlanInputs + index;
      const Result<int> file = open_given(files, help.files[index]);
      if (!file) return tl::unexpected<Error>(file.error());
      const Result<ShopFile> about = read_digest(*file);
      if (!about) return tl::unexpected<Error>(about.error());
      all += about->bytes;
      if (all > kMostShopBytes) return fail(Code::kInput, "the plan is too large for the shop's queue");
      const auto row =
          ask(kPlanMadeFile, {machine, order.id, order.token, number, about->sha256, about->bytes});
      if (!row) return tl::unexpected<Error>(row.error());
      mine = !row->rows.empty();
      std::uint64_t piece = 0;
      const Result<ShopFile> sent = read_pieces(*file, [&](const std::string& bytes) -> Result<void> {
        if (!mine) return {};
        const auto kept =
            ask(kPlanMadePiece, {machine, order.id, order.token, number, piece++, {bytes, true}});
        if (!kept) return tl::unexpected<Error>(kept.error());
        mine = !kept->rows.empty();
        return {};
      });
      if (!sent) return tl::unexpected<Error>(sent.error());
    }
    return {};
  };
  const Result<void> given = give_all();
  if (!given && given.error().code != Code::kInput) return given;
  const auto told =
      given ? ask(kPlanDone, {machine, order.id, order.token, version, order.from})
            : ask(kPlanFail, {machine, order.id, order.token, shown(given.error().message, kLongestNote)});
  if (!told) return tl::unexpected<Error>(told.error());
  return {};
}

Result<void> ShopPlans::take(const ShopAsk& ask, const std::string& machine, const std::string& version) {
  const auto rows = ask(kPlanTake, {machine, version});
  if (!rows) return tl::unexpected<Error>(rows.error());
  if (rows->rows.empty()) return {};
  const PgRow& row = rows->rows[0];
  const auto token = row.size() == 4 ? whole_number(row[1]) : std::nullopt;
  if (!token || !is_uuid(row[0])) return not_plans("an order of planning that was taken");
  PlanTaken order{row[0], *token, shown(row[2], kLongestName), shown(row[3], kLongestName), ""};
  Result<std::vector<int>> fetched = fetch(ask, order.id, 0, 0, kPlanInputs, &order.from);
  if (!fetched && fetched.error().code == Code::kInput) {
    const auto told =
        ask(kPlanFail, {machine, order.id, order.token, shown(fetched.error().message, kLongestNote)});
    return told ? Result<void>() : tl::unexpected<Error>(told.error());
  }
  if (!fetched) return tl::unexpected<Error>(fetched.error());
  const OpenFiles files(std::move(*fetched));
  const Result<bool> begun = ledger_.take(order, files.all());
  if (!begun) return tl::unexpected<Error>(begun.error());
  if (*begun) return {};
  const auto back = ask(kPlanBack, {machine, order.id, order.token});
  return back ? Result<void>() : tl::unexpected<Error>(back.error());
}

Result<std::vector<ShopPlan>> view_plans(const ShopAsk& ask) {
  const auto rows = ask(
      "SELECT p.id, left(p.name, 100), coalesce(left(a.name, 100), ''), coalesce(left(h.name, 100), ''), "
      "CASE WHEN "
      "p.state = 'taken' AND p.lease < now() THEN 'open' ELSE p.state END, p.percent, p.stage, extract(epoch "
      "FROM p.asked)::bigint FROM tiltfeed.plans p LEFT JOIN tiltfeed.machines a ON a.id = p.asker LEFT JOIN "
      "tiltfeed.machines h ON h.id = p.helper ORDER BY p.number LIMIT 200",
      {});
  if (!rows) return tl::unexpected<Error>(rows.error());
  std::vector<ShopPlan> plans;
  for (const PgRow& row : rows->rows) {
    constexpr std::size_t kColumns = 8;
    if (row.size() != kColumns) return not_plans("an order of planning");
    ShopPlan plan{row[0], row[1], row[2], row[3],
                  row[4], row[6], 0,      std::strtoll(row[7].c_str(), nullptr, 10)};
    plan.percent = static_cast<int>(std::min<std::uint64_t>(whole_number(row[5]).value_or(0), 100));
    if (plan.state == "open") plan.helper.clear();
    plans.push_back(std::move(plan));
  }
  return plans;
}

}  // namespace tiltfeed::daemon
