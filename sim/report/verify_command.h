#pragma once
// `tiltfeed-sim verify`, which `tiltfeed verify` runs: a program or a trace against stock and part.

#include <optional>
#include <string>

namespace tiltfeed::sim {

struct VerifyOptions {
  std::string job, program, trace, canon;  ///< the job, and one of the three
  std::string stock;                       ///< as for parse_stock; empty: the job's default
  std::optional<double> resolution;        ///< mm; absent: chosen from the tool and the part's size
  std::string out;                         ///< folder of the report, or its page (.html); empty: none
  std::string stl, machine;                ///< instead of the job's; empty: the job's
  std::string operation;                   ///< of the job, whose moves these are; empty: all of them
  std::string progress;                    ///< a file that says what it is at; empty: none
  int bundles = 1;                         ///< of the stock's lines: 1, along the tool's main direction, or 3
  int threads = 0;                         ///< 0: as many as the machine has
  bool as_json = false;                    ///< the report instead of its summary, on standard output
};

/// Prints the verdict, writes the report. The exit status: 0 passed, 1 failed or an error, 2 wrong use,
/// 3 incomplete.
int verify_command(const VerifyOptions& options);

}  // namespace tiltfeed::sim
