#pragma once
// The command line of the service and of its clients.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds serve, safe-stop, submit, list, show, start, hold, resume, stop, remove, watch and override to the
/// command line.
class ServiceCommands {
 public:
  /// `version`: of this program.
  ServiceCommands(CLI::App& app, const std::string& version);
  ~ServiceCommands();
  /// The exit status, when one of them was called.
  std::optional<int> run();

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
