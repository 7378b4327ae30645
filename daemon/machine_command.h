#pragma once
// `tiltfeed machine check`: whether a profile is that of the machine in the shop.

#include <memory>
#include <string>

#include "config/machine_profile.h"
#include "kinematics/result.h"

namespace CLI {
class App;
}

namespace tiltfeed {

/// A short program that holds the tool tip still on the part while the rotaries turn, with a stop at each
/// place and, in comments, where the tip should be and how the tool should lean. Part zero is the point of
/// the rotary table's axis; the tip stays `height` mm above it. Only places within the limits. Errors: kLimit
/// where there is none.
Result<std::string> check_program(const MachineProfile& machine, double tool_length, double height);

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
