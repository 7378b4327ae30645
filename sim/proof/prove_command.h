#pragma once
// `tiltfeed-sim prove`: every move of a program against the part. `tiltfeed plan` runs it on what it wrote
// before the program gets its name.

#include <string>

namespace tiltfeed::sim {

struct ProveOptions {
  std::string job, program;  ///< the program in the dialect of the job's machine
  std::string stl, machine;  ///< instead of the job's; empty: as the job says
  std::string operation;     ///< of the job, whose program it is alone; empty: all of them
  std::string name;          ///< of the program in messages; empty: as `program`
  std::string picture;       ///< PNG file of a gouge; empty: none
  bool closed = false;       ///< no other file that the job names is read
  bool told = false;         ///< the program is whole when a line has come on standard input
  bool progress = false;     ///< lines "progress 0.25" on standard output
  int threads = 0;           ///< 0: as many as the machine has
};

/// Prints "proven N moves, largest gouge D mm" or what is wrong. The exit status: 0 proven, 1 a gouge or an
/// error, 2 wrong use.
int prove_command(const ProveOptions& options);

}  // namespace tiltfeed::sim
