#pragma once
// `tiltfeed tools`: a shop's tool library, and tools of other programs for it.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class ToolsCommand {
 public:
  explicit ToolsCommand(CLI::App& app);
  ~ToolsCommand();
  ToolsCommand(const ToolsCommand&) = delete;
  ToolsCommand& operator=(const ToolsCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
