#pragma once
// `tiltfeed submit`: to the service of one machine, or to the shop's queue.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class SubmitCommand {
 public:
  explicit SubmitCommand(CLI::App& app);
  ~SubmitCommand();
  SubmitCommand(const SubmitCommand&) = delete;
  SubmitCommand& operator=(const SubmitCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
