#pragma once
// One run of a job, as the spool keeps it: who, when, what, how it ended.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/service/run_tally.h"

namespace tiltfeed::daemon {

struct RunReport {
  std::uint64_t id = 0, job = 0;
  std::string name, hash, link;  ///< hash: of the program, hexadecimal
  /// Who gave the word that started it; nothing: not known (a place in the queue from before a restart).
  std::optional<std::uint32_t> user;
  std::int64_t began = 0;               ///< seconds since 1970
  std::optional<std::int64_t> ended;    ///< nothing: it goes on, or nobody saw its end
  std::uint64_t first = 1, blocks = 0;  ///< first block of this run; blocks of the whole program
  std::uint64_t executed = 0;           ///< of the whole program, surely: a lower bound
  std::string outcome;                  ///< state of the job afterwards; empty: the run goes on
  std::string note;                     ///< why, in words
  /// Of a run whose end the service saw.
  struct Figures {
    std::uint64_t sent = 0, resends = 0;
    double seconds = 0.0;  ///< since its first block
    int holds = 0;
    double held_seconds = 0.0;
    std::optional<double> slowest_hold;
    std::optional<RunTally::Percent> feed_override;
    std::optional<double> starved_seconds;
  };
  std::optional<Figures> figures;
};

/// An object a run; what is not known is null.
std::string runs_json(const std::vector<RunReport>& runs);

}  // namespace tiltfeed::daemon
