#pragma once
// A shop's database in memory, written from the words of shop_layout.h: what is asked of it, asks that are
// lost before or behind their work, copies of yesterday, restarts.

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "daemon/shop/shop_client.h"
#include "daemon/shop/shop_layout.h"

namespace tiltfeed {

class ShopDatabase {
 public:
  static constexpr long kLease = 30, kRollCall = 20;  ///< s
  struct Job {
    std::uint64_t number = 0;
    std::string name = "part", needs = "{}", sha256, text, state = "open", note, machine;
    std::uint64_t bytes = 0, epoch = 0, token = 0, version = 0;
    bool program = true;
    long lease = 0;
  };
  struct Machine {
    std::string incarnation;
    std::uint64_t serial = 0;
    bool told = false, away = false;
  };
  struct Content {
    std::string shop = daemon::make_uuid(), epoch_id = daemon::make_uuid(), incarnation, halted;
    std::uint64_t epoch = 1, token = 0, numbers = 0;
    long began = 0;
    std::map<std::string, Machine> machines;
    std::map<std::string, Job> jobs;
    std::map<std::string, std::map<std::uint64_t, std::string>> states;  ///< by machine and time
  };

  void submit(const std::string& id, const std::string& text) {
    if (content.jobs.contains(id)) {
      // Only what a job still needs that the database has lost.
      Job& known = content.jobs[id];
      if (!known.text.empty() || (known.state != "accepted" && known.state != "spoiled")) return;
      known.text = text;
      known.bytes = text.size();
      if (known.state == "spoiled")
        known.state = "open", known.machine.clear(), known.token = ++content.token;
      if (known.state == "open") known.epoch = content.epoch, known.version = 0;
      return;
    }
    Job job;
    job.number = ++content.numbers;
    job.text = text;
    job.bytes = text.size();
    job.sha256 = daemon::hex(daemon::sha256(text));
    content.jobs[id] = job;
  }
  void restart() { born = "born " + std::to_string(++starts); }
  void raise() {
    ++content.epoch;
    content.epoch_id = daemon::make_uuid();
    content.halted.clear();
  }
  bool everybody_told() const {
    return std::all_of(content.machines.begin(), content.machines.end(), [&](const auto& one) {
      return one.second.away || (one.second.told && one.second.incarnation == content.incarnation);
    });
  }

  /// Of a client whose asks are lost so often, in a thousand.
  daemon::ShopAsk asked(std::mt19937& random, int lost) {
    return [this, &random, lost](const std::string& sql,
                                 const std::vector<daemon::PgValue>& values) -> Result<daemon::PgRows> {
      const int chance = static_cast<int>(random() % 1000);
      if (chance < lost) return fail(Code::kLink, "lost before it was done");
      std::vector<std::string> v;
      for (const daemon::PgValue& value : values) v.push_back(value.text);
      const Result<daemon::PgRows> done = answer(sql, v);
      if (chance < 2 * lost) return fail(Code::kLink, "done, and its answer lost");
      return done;
    };
  }

  Content content;
  long now = 0;
  bool roll_call = true;  ///< false: the seeded bug

 private:
  static std::uint64_t number(const std::string& text) { return std::stoull(text); }
  bool can_be_claimed(const Job& job) const {
    return job.state == "open" || (job.state == "claimed" && job.lease < now);
  }
  Result<daemon::PgRows> answer(const std::string& sql, const std::vector<std::string>& v) {
    if (sql == daemon::kShopHello) return hello(v);
    if (sql == daemon::kShopTold) return content.machines[v[0]].told = true, daemon::PgRows();
    if (sql == daemon::kShopOpen) return open(number(v[0]));
    if (sql == daemon::kShopClaim) return claim(v);
    if (sql == daemon::kShopAccept) return accept(v);
    if (sql == daemon::kShopReport) return report(v);
    if (sql == daemon::kShopPiece) return piece(v);
    if (sql == daemon::kShopStates) return states(v);
    if (sql == daemon::kShopGone) return gone(v);
    if (sql == daemon::kShopRefuse) {
      content.jobs[v[1]].state = "held";
      content.jobs[v[1]].note = v[4];
      return daemon::PgRows();
    }
    return fail(Code::kInput, "not known here: " + sql);
  }
  static std::vector<std::string> array(const std::string& text) {
    std::vector<std::string> items{""};
    for (const char c : text.substr(1, text.size() - 2))
      c == ',' ? items.push_back("") : items.back().push_back(c);
    return items;
  }
  daemon::PgRows states(const std::vector<std::string>& v) {
    const auto times = array(v[1]), words = array(v[2]);
    for (std::size_t i = 0; i < times.size(); ++i)
      content.states[v[0]].emplace(number(times[i]), words.at(i));
    return {{{""}}};
  }
  daemon::PgRows hello(const std::vector<std::string>& v) {
    Content& c = content;
    if (c.incarnation != born) c.incarnation = born, c.began = now;
    Machine& m = c.machines[v[0]];
    const std::uint64_t epoch = number(v[5]), token = number(v[7]), serial = number(v[8]);
    if (v[4] == c.shop && (epoch > c.epoch || (epoch == c.epoch &&
                                               (v[6] != c.epoch_id || token > c.token || serial > m.serial))))
      c.halted = "behind";
    m.told = m.told && m.incarnation == born;
    m.incarnation = born;
    m.away = false;
    return {{{std::to_string(daemon::kShopLayout), c.shop, std::to_string(c.epoch), c.epoch_id,
              std::to_string(c.token), std::to_string(m.serial), c.halted, m.told ? "t" : "f"}}};
  }
  daemon::PgRows open(std::uint64_t after) const {
    std::vector<std::pair<std::uint64_t, daemon::PgRow>> all;
    for (const auto& [id, job] : content.jobs)
      if (can_be_claimed(job) && job.number > after)
        all.push_back({job.number, {id, std::to_string(job.number), job.needs}});
    std::sort(all.begin(), all.end());
    daemon::PgRows rows;
    for (auto& [place, row] : all)
      if (rows.rows.size() < daemon::kShopPage) rows.rows.push_back(row);
    return rows;
  }
  daemon::PgRows claim(const std::vector<std::string>& v) {
    Content& c = content;
    const bool waits = roll_call && now < c.began + kRollCall && !everybody_told();
    if (!c.halted.empty() || number(v[2]) != c.epoch || v[3] != c.epoch_id || c.incarnation != born || waits)
      return {};
    Job* best = nullptr;
    std::string id;
    for (auto& [one, job] : c.jobs)
      if (v[1].find(one) != std::string::npos && can_be_claimed(job) &&
          (best == nullptr || job.number < best->number))
        best = &job, id = one;
    if (best == nullptr) return {};
    best->state = "claimed", best->machine = v[0], best->epoch = c.epoch, best->token = ++c.token;
    best->version = 0, best->lease = now + kLease;
    return {{{id, std::to_string(c.epoch), std::to_string(c.token), std::to_string(best->number), best->name,
              best->program ? "t" : "f", best->sha256, std::to_string(best->bytes), best->sha256,
              std::to_string(best->bytes)}}};
  }
  daemon::PgRows accept(const std::vector<std::string>& v) {
    if (!content.halted.empty()) return {{{"halted", "0"}}};
    const auto at = content.jobs.find(v[1]);
    if (at == content.jobs.end() || at->second.machine != v[0] || at->second.epoch != number(v[2]) ||
        at->second.token != number(v[3]) || (at->second.state != "claimed" && at->second.state != "accepted"))
      return {{{"lost", "0"}}};
    at->second.state = "accepted";
    return {{{"accepted", std::to_string(++content.machines[v[0]].serial)}}};
  }
  daemon::PgRows report(const std::vector<std::string>& v) {
    Content& c = content;
    if (!c.jobs.contains(v[1])) {
      c.jobs[v[1]].number = ++c.numbers;
      c.jobs[v[1]].sha256 = v[12];
    }
    Job& job = c.jobs[v[1]];
    const std::pair stored{job.epoch, job.token}, told{number(v[2]), number(v[3])};
    const bool begun = v[11] == "true";
    if (stored > told || (stored == told && job.machine != v[0])) {
      if (begun && (job.state == "open" || job.state == "claimed")) job.state = "held";
      return {{{"overruled", "it is " + job.state, "0"}}};
    }
    if (stored == told && job.version > number(v[4])) return {{{"overruled", "older", "0"}}};
    job.machine = v[0], job.epoch = told.first, job.token = told.second, job.version = number(v[4]);
    job.state = v[5], job.note = v[6];
    if (c.epoch == told.first) c.token = std::max(c.token, told.second);
    return {{{"taken", "", std::to_string(++c.machines[v[0]].serial)}}};
  }
  daemon::PgRows piece(const std::vector<std::string>& v) const {
    const auto at = content.jobs.find(v[0]);
    const std::size_t from = number(v[2]) * daemon::kShopPieceBytes;
    if (at == content.jobs.end() || from >= at->second.text.size()) return {};
    std::string hex;
    for (const char c : at->second.text.substr(from, daemon::kShopPieceBytes)) {
      char two[3];
      std::snprintf(two, sizeof two, "%02x", static_cast<unsigned char>(c));
      hex += two;
    }
    return {{{hex}}};
  }
  daemon::PgRows gone(const std::vector<std::string>& v) const {
    daemon::PgRows rows;
    for (const auto& [id, job] : content.jobs)
      if (v[0].find(id) != std::string::npos && job.machine != v[1]) rows.rows.push_back({id, job.state});
    return rows;
  }

  int starts = 1;
  std::string born = "born 1";
};

}  // namespace tiltfeed
