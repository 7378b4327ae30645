#pragma once
// `tiltfeed machine ...`: whether a profile is that of the machine in the shop, and what an operator does
// with that machine before and after a program.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed::daemon {

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
