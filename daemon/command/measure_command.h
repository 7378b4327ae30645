#pragma once
// `tiltfeed machine measure`: pivots, directions and zeros of the rotaries from a measured ball.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to those of `tiltfeed machine`; after it is parsed, runs it.
class MeasureCommand {
 public:
  explicit MeasureCommand(CLI::App& machine);
  ~MeasureCommand();
  MeasureCommand(const MeasureCommand&) = delete;
  MeasureCommand& operator=(const MeasureCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
