#pragma once
// The orders of planning of a shop's database in memory, written from the words of shop_plan_layout.h.

#include <map>
#include <random>
#include <string>
#include <vector>

#include "daemon/files/sha256.h"
#include "daemon/shop/shop_layout.h"
#include "daemon/shop/shop_plan_layout.h"
#include "daemon/shop/shop_plans.h"

namespace tiltfeed {

class PlanDatabase {
 public:
  static constexpr long kLease = 60;
  struct File {
    std::string sha256;
    std::uint64_t bytes = 0;
    std::map<std::uint64_t, std::string> pieces;
  };
  struct Plan {
    std::uint64_t number = 0, token = 0;
    std::string asker, name, version, state = "open", helper, percent = "0", stage, note, by, from;
    int tries = 0;
    long lease = 0;
    std::map<std::pair<std::uint64_t, std::uint64_t>, File> files;  ///< by token and number
  };

  /// Of a client whose asks are lost so often, in a thousand.
  daemon::ShopAsk asked(std::mt19937& random, int lost) {
    return [this, &random, lost](const std::string& sql,
                                 const std::vector<daemon::PgValue>& values) -> Result<daemon::PgRows> {
      const int chance = static_cast<int>(random() % 1000);
      if (chance < lost) {
        if (in_transaction) plans = before, in_transaction = false;
        return fail(Code::kLink, "lost before it was done");
      }
      std::vector<std::string> v;
      for (const daemon::PgValue& value : values) v.push_back(value.text);
      const Result<daemon::PgRows> done = answer(sql, v);
      if (chance >= 2 * lost) return done;
      if (in_transaction) plans = before, in_transaction = false;
      return fail(Code::kLink, "done, and its answer lost");
    };
  }

  std::map<std::string, Plan> plans;
  std::map<std::string, std::string> offers;  ///< version by machine
  long now = 0;

 private:
  using Rows = daemon::PgRows;
  static std::uint64_t number(const std::string& text) { return std::stoull(text); }
  /// v: machine, id, token.
  Plan* mine(const std::vector<std::string>& v) {
    const auto found = plans.find(v[1]);
    if (found == plans.end()) return nullptr;
    Plan& plan = found->second;
    const bool is = plan.helper == v[0] && plan.token == number(v[2]) && plan.state == "taken";
    return is ? &plan : nullptr;
  }
  bool is_open(const Plan& plan) const {
    return plan.state == "open" || (plan.state == "taken" && plan.lease < now);
  }
  bool has_order(const std::string& machine) const {
    for (const auto& [id, plan] : plans)
      if (plan.helper == machine && plan.state == "taken" && plan.lease >= now) return true;
    return false;
  }
  Result<Rows> answer(const std::string& sql, const std::vector<std::string>& v) {
    using namespace daemon;
    if (sql == "BEGIN") return before = plans, in_transaction = true, Rows();
    if (sql == "ROLLBACK") return plans = before, in_transaction = false, Rows();
    if (sql == "COMMIT") return in_transaction = false, Rows();
    if (sql == kShopNotify) return Rows();
    if (sql == kPlanOffer) return offers[v[0]] = v[1], Rows();
    if (sql == kPlanForget) return Rows();
    if (sql == kPlanHelpers) {
      for (const auto& [machine, version] : offers)
        if (machine != v[0] && version == v[1]) return Rows{{{"1"}}};
      return Rows();
    }
    if (sql == kPlanIdle) {
      for (const auto& [machine, version] : offers)
        if (machine != v[0] && version == v[1] && !has_order(machine)) return Rows{{{"1"}}};
      return Rows();
    }
    if (sql == kPlanAsk) {
      if (plans.contains(v[0])) return Rows();
      Plan& plan = plans[v[0]];
      plan.number = ++numbers, plan.asker = v[1], plan.name = v[2], plan.version = v[3];
      return Rows{{{v[0]}}};
    }
    if (sql == kPlanGiveFile)
      return plans.at(v[0]).files[{0, number(v[1])}] = File{v[2], number(v[3]), {}}, Rows();
    if (sql == kPlanGivePiece)
      return plans.at(v[0]).files.at({0, number(v[1])}).pieces[number(v[2])] = v[3], Rows();
    if (sql == kPlanSeen) {
      Rows rows;
      for (const auto& [id, plan] : plans)
        if (plan.asker == v[0])
          rows.rows.push_back({id, plan.state == "taken" && is_open(plan) ? "open" : plan.state, plan.helper,
                               std::to_string(plan.token), plan.percent, plan.stage, plan.note, plan.by,
                               plan.from});
      return rows;
    }
    if (sql == kPlanDrop) return plans.erase(v[0]), Rows();
    if (sql == kPlanTake) return take(v);
    if (sql == kPlanFiles) return files(v);
    if (sql == kPlanPiece) return piece(v);
    if (sql == kPlanBackAll) {
      for (auto& [id, plan] : plans)
        if (plan.helper == v[0] && plan.state == "taken") plan.state = "open", plan.helper.clear();
      return Rows();
    }
    Plan* const plan = mine(v);
    if (plan == nullptr) return Rows();
    if (sql == kPlanKeep) plan->lease = now + kLease, plan->percent = v[3], plan->stage = v[4];
    if (sql == kPlanBack) plan->state = "open", plan->helper.clear(), --plan->tries;
    if (sql == kPlanFail) plan->state = "failed", plan->note = v[3];
    if (sql == kPlanUnmade)
      std::erase_if(plan->files, [&](const auto& one) { return one.first.first == plan->token; });
    if (sql == kPlanMadeFile) {
      if (plan->files.contains({plan->token, number(v[3])})) return fail(Code::kInput, "it is there already");
      plan->files[{plan->token, number(v[3])}] = File{v[4], number(v[5]), {}};
    }
    if (sql == kPlanMadePiece) {
      plan->files.at({plan->token, number(v[3])}).pieces[number(v[4])] = v[5];
      plan->lease = now + kLease;
    }
    if (sql == kPlanDone) plan->state = "done", plan->by = v[3], plan->from = v[4];
    return Rows{{{v[1]}}};
  }
  Rows take(const std::vector<std::string>& v) {
    Plan* best = nullptr;
    std::string id;
    for (auto& [key, plan] : plans)
      if (is_open(plan) && plan.version == v[1] && plan.asker != v[0] && plan.tries < 3 &&
          (best == nullptr || plan.number < best->number))
        best = &plan, id = key;
    if (best == nullptr) return {};
    best->state = "taken", best->helper = v[0], ++best->token, ++best->tries, best->lease = now + kLease;
    return {{{id, std::to_string(best->token), best->name, best->asker}}};
  }
  Rows files(const std::vector<std::string>& v) {
    Rows rows;
    if (!plans.contains(v[0])) return rows;
    for (const auto& [key, file] : plans.at(v[0]).files)
      if (key.first == number(v[1]))
        rows.rows.push_back({std::to_string(key.second), file.sha256, std::to_string(file.bytes)});
    return rows;
  }
  Rows piece(const std::vector<std::string>& v) {
    if (!plans.contains(v[0])) return {};
    const auto& all = plans.at(v[0]).files;
    const auto file = all.find({number(v[1]), number(v[2])});
    if (file == all.end() || !file->second.pieces.contains(number(v[3]))) return {};
    std::string digits;
    for (const char byte : file->second.pieces.at(number(v[3]))) {
      char two[3];
      std::snprintf(two, sizeof two, "%02x", static_cast<unsigned>(static_cast<unsigned char>(byte)));
      digits += two;
    }
    return {{{digits}}};
  }

  std::map<std::string, Plan> before;
  bool in_transaction = false;
  std::uint64_t numbers = 0;
};

}  // namespace tiltfeed
