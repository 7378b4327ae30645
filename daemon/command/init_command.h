#pragma once
// `tiltfeed init`: the first job of a part, with the questions that only a person can answer.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class InitCommand {
 public:
  explicit InitCommand(CLI::App& app);
  ~InitCommand();
  InitCommand(const InitCommand&) = delete;
  InitCommand& operator=(const InitCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
