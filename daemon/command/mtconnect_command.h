#pragma once
// `tiltfeed mtconnect`: a service's machine for MTConnect agents.

#include <memory>
#include <string>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// Adds the command to the command line; after it is parsed, runs it.
class MtconnectCommand {
 public:
  MtconnectCommand(CLI::App& app, const std::string& version);
  ~MtconnectCommand();
  MtconnectCommand(const MtconnectCommand&) = delete;
  MtconnectCommand& operator=(const MtconnectCommand&) = delete;

  bool called() const;
  /// Serves agents until SIGINT or SIGTERM. The exit status: 0 done; 1 failed; 2 wrong use.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
