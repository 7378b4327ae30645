#pragma once
// `tiltfeed metrics`: the figures of a service for a monitoring system.

#include <memory>
#include <string>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class MetricsCommand {
 public:
  MetricsCommand(CLI::App& app, const std::string& version);
  ~MetricsCommand();
  MetricsCommand(const MetricsCommand&) = delete;
  MetricsCommand& operator=(const MetricsCommand&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, also where no service answers; 1 failed; 2 wrong use.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
