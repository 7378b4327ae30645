#pragma once
// What a receiver is told: a run that is done or has ended in a fault, a machine that is not answered any
// more.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::desk {

/// A run as the service's history has it (daemon/service/API.md). Times: seconds since 1970.
struct ToldRun {
  std::uint64_t run = 0, job = 0, blocks = 0, executed = 0;
  std::int64_t began = 0;
  std::optional<std::int64_t> ended;
  std::string name, sha256, outcome, note;

  bool goes_on() const { return outcome == "running"; }
};

struct HistoryPage {
  std::vector<ToldRun> runs;
  bool more = false;
};

/// Rows that are not understood are left out. Errors: kIo: the answer is none.
Result<HistoryPage> read_history(const std::string& reply);

struct HookMessage {
  std::string id;  ///< the same whenever the same event is found again
  bool fault = false;
  std::string body;  ///< JSON, ASCII
};

/// Nothing for a run that goes on, or ended as its operator wished: stopped, or at a tool change.
/// `seen`: when the desk learnt of it, for a run whose end nobody saw.
std::optional<HookMessage> message_of(const ToldRun& run, const std::string& machine, std::int64_t seen);

/// `since`: when the machine's service was last asked in vain first; `run`: what was on the machine.
HookMessage lost_message(const std::string& machine, std::int64_t since, const std::string& why,
                         const std::optional<ToldRun>& run);

}  // namespace tiltfeed::desk
