#pragma once
// `tiltfeed help TOPIC`, and what the build makes of the same: manual pages and completion.

#include <memory>
#include <string>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the commands to the command line; after it is parsed, runs the one that was called.
class ManualCommand {
 public:
  ManualCommand(CLI::App& app, const std::string& version);
  ~ManualCommand();
  ManualCommand(const ManualCommand&) = delete;
  ManualCommand& operator=(const ManualCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
