#pragma once
// `tiltfeed history`: the runs of a service's machine.

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "kinematics/basics/result.h"

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// All runs on record, the oldest first; of one job, or of all (0). Errors: kIo, kInput.
Result<nlohmann::json> ask_runs(const std::string& socket, std::uint64_t job);

/// Adds the command to the command line; after it is parsed, runs it.
class HistoryCommand {
 public:
  explicit HistoryCommand(CLI::App& app);
  ~HistoryCommand();
  HistoryCommand(const HistoryCommand&) = delete;
  HistoryCommand& operator=(const HistoryCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
