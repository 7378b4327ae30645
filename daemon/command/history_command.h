#pragma once
// `tiltfeed history`: the runs of a service's machine.

#include <memory>
#include <string>

#include "kinematics/basics/result.h"

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// The last runs on record, so many at most, the oldest first: a JSON object a line. Errors: kIo, kInput.
Result<std::string> last_runs(const std::string& socket, std::size_t most);

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
