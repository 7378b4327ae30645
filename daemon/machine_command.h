#pragma once
// `tiltfeed machine check`: whether a profile is that of the machine in the shop.

#include <memory>

namespace CLI {
class App;
}

namespace tiltfeed {

/// Adds the command to the command line; after it is parsed, runs it.
class MachineCommands {
 public:
  explicit MachineCommands(CLI::App& app);
  ~MachineCommands();
  MachineCommands(const MachineCommands&) = delete;
  MachineCommands& operator=(const MachineCommands&) = delete;

  bool called() const;
  /// The program's exit status: 0 done, 1 failed; messages go to standard error.
  int run() const;

 private:
  struct Options;
  std::unique_ptr<Options> options_;
};

}  // namespace tiltfeed
