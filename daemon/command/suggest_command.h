#pragma once
// `tiltfeed suggest`: where the tool axis of a part might go.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class SuggestCommand {
 public:
  explicit SuggestCommand(CLI::App& app);
  ~SuggestCommand();
  SuggestCommand(const SuggestCommand&) = delete;
  SuggestCommand& operator=(const SuggestCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
