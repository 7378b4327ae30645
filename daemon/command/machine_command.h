#pragma once
// `tiltfeed machine ...`: whether a profile is that of the machine in the shop, and what an operator does
// with that machine before and after a program.

#include <memory>
#include <string>
#include <vector>

#include "daemon/machine/machine_orders.h"

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

/// A command over a link of its own. Errors: as perform_order; kUsage: somebody else has the machine; kLink.
Result<MachineAnswer> act_over(const LinkSpec& link, const config::MachineProfile& machine,
                               const std::string& name, const std::vector<std::string>& words);
/// A command through the service: begun, then asked for until it has ended, with the operator's words in
/// between. Errors: as perform_order; kIo.
Result<MachineAnswer> act_through(const std::string& socket, const std::string& name,
                                  const std::vector<std::string>& words);

/// Adds the commands to the command line; after it is parsed, runs the one that was called.
class MachineCommands {
 public:
  explicit MachineCommands(CLI::App& app);
  ~MachineCommands();
  MachineCommands(const MachineCommands&) = delete;
  MachineCommands& operator=(const MachineCommands&) = delete;

  bool called() const;
  /// It talks to a machine: then an interrupt ends the motion in order, not the process.
  bool at_machine() const;
  /// The program's exit status: 0 done, 1 failed, 2 wrong use; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed::daemon
