#pragma once
// `tiltfeed post` and `tiltfeed unpost`: CL text to a program, and back.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds both commands to the command line; after it is parsed, runs the one that was called.
class PostCommands {
 public:
  explicit PostCommands(CLI::App& app);
  ~PostCommands();
  PostCommands(const PostCommands&) = delete;
  PostCommands& operator=(const PostCommands&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
