#pragma once
// `tiltfeed-sim engagement`: what the cutter has to do, block by block. `tiltfeed plan --optimise feed` runs
// it.

#include <optional>
#include <string>

namespace tiltfeed::sim {

struct EngagementFiles {
  std::string job, program;
  std::string stock;                 ///< as for parse_stock; empty: the job's default
  std::optional<double> resolution;  ///< mm; absent: chosen from the tools and the part's size
  std::string stl, machine;          ///< instead of the job's; empty: the job's
  std::string operation;             ///< of the job, whose program it is alone; empty: all of them
  std::string table;                 ///< CSV to write; empty: none
  std::string plot;                  ///< SVG to write; empty: none
  std::string before;     ///< such a table of another program of the job, for the plot; empty: none
  bool progress = false;  ///< lines "progress 0.25" on standard output
  int threads = 0;        ///< 0: as many as the machine has
};

/// Prints a line of figures for each operation. The exit status: 0 done, 1 an error, 2 wrong use.
int engagement_command(const EngagementFiles& files);

}  // namespace tiltfeed::sim
