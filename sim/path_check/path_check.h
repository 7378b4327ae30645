#pragma once
// The proof that a job was done right, from the executed trace alone: own reader, own forward kinematics,
// own distances. Nothing here was used to plan or to post.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"
#include "sim/motion/trace.h"
#include "sim/path_check/block_comparison.h"
#include "sim/path_check/executed.h"
#include "sim/path_check/path_check_report.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed::sim {

struct PathCheckOptions {
  double tolerance = 0.0;       ///< for gouge, gap and tip, mm; 0: the job's
  double axis_tolerance = 0.2;  ///< degrees; twice what the post allows itself
  int samples_per_block = 5;    ///< at least; evenly spaced, the block's end included
  double max_step = 0.0;        ///< of any point of the tool between two samples, mm; 0: a quarter of its
                                ///< least radius
  int threads = 2;              ///< the report is the same for any number
};

/// Within a block every axis word moves linearly; the first motion block only states the start pose.
/// `part`: the checked mesh of the job's STL. Requires: planned, its axes unit.
/// Errors: kInput when the trace has no motion, the planned path no points or the part no facets; kCancelled
/// when cancelled.
Result<PathCheckReport> check_path(const config::Job& job, const pathgen::Mesh& part,
                                   const std::vector<Block>& program, const ToolPath& planned,
                                   const std::vector<TraceRow>& trace, const PathCheckOptions& options,
                                   const pathgen::Progress& progress);

/// The report as JSON, keys with units, indented.
std::string to_json(const PathCheckReport& report);

}  // namespace tiltfeed::sim
