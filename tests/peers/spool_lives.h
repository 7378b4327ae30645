#pragma once
// A service's lives over one spool, and what the world outside knows: what was answered, what left for the
// machine and what that executed. Every step is the product's own, in the order of JobService.

#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>

#include "daemon/journal/program_run.h"
#include "daemon/service/spool.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;

/// One submission, from outside.
struct KnownJob {
  std::string text;  ///< of its program, or of its description
  bool program = true;
  bool answered = false;                 ///< it was taken
  bool leaving = false, gone = false;    ///< to be removed; was
  std::set<JobState> states;             ///< the spool may say
  RunSubject run;                        ///< the newest one
  std::uint64_t left = 0, executed = 0;  ///< blocks of it: handed to the wire; moved by the machine
};

class SpoolLives {
 public:
  explicit SpoolLives(std::string folder, std::uint64_t seed) : folder_(std::move(folder)), random_(seed) {}

  /// Work in any order, until its end or until the disk says no.
  void live(int steps);
  /// The same work each time: jobs of both kinds, a whole run, one that is cut off and goes on, a removal.
  void story();
  /// All that is left, in that folder or a copy of it, against what is known. Requires: the disk is sound.
  void look(const std::string& folder);
  /// The computer was off, the machine was not.
  void reboot();

  const std::string& wrong() const { return wrong_; }
  std::uint64_t submissions() const { return submitted_; }
  std::uint64_t runs() const { return runs_; }

 private:
  void complain(const std::string& what) {
    if (wrong_.empty()) wrong_ = what;
  }
  std::uint64_t any(std::uint64_t count) { return random_() % count; }
  HostBoot host() const;
  std::string program_of(const SpooledJob& job) const;
  void judge(const SpooledJob& row, const Spool& spool);
  void judge_run(const KnownJob& known, const SpooledJob& row, const Spool& spool);
  ResumeDecision decision_of(const KnownJob& known, std::uint64_t id, const Spool& spool) const;
  std::optional<SpooledJob> row_of(const Spool& spool, const std::string& name) const;

  void step(Spool& spool, const SpooledJob& row);
  bool set(Spool& spool, SpooledJob row, JobState state);
  void settle(Spool& spool);
  std::string submit(Spool& spool, bool program, std::size_t size);
  void plan(Spool& spool, SpooledJob row);
  void start(Spool& spool, SpooledJob row, LinkKind kind, std::uint64_t total, std::uint64_t until);
  void stream(Spool& spool, SpooledJob row, const ResumeDecision& decision, std::uint64_t until);
  bool send(KnownJob& known, RunRecorder& recorder, std::uint64_t until);
  void remove(Spool& spool, const SpooledJob& row);

  std::string folder_, wrong_;
  std::mt19937_64 random_;
  std::map<std::string, KnownJob> known_;
  std::uint64_t boots_ = 1, runs_ = 0, submitted_ = 0;
};

}  // namespace tiltfeed
