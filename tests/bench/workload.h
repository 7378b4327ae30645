#pragma once
// What the benchmarks measure: one way from an STL file to the tool path in memory, in a process of its own,
// so that neither the allocator's leftovers nor the memory of the run before count.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed::bench {
using namespace pathgen;
using namespace config;

/// The part that height_field.h makes.
inline constexpr const char* kHeightField = "field";

struct Workload {
  std::string job;         ///< file
  std::string stl;         ///< file; empty: the job's
  double side_step = 0.0;  ///< mm; 0: the job's
  bool fixed = false;      ///< the tool axis stays as it is in the middle of the job's pattern: 3 axes
  bool any_tilt = false;   ///< nothing is left out for the head's sake
  int threads = 0;         ///< 0: as many as there are cores
};

struct Sample {
  double seconds = 0.0, processor_seconds = 0.0;  ///< read_stl + check_mesh + plan
  double plan_processor_seconds = 0.0;            ///< plan alone
  std::uint64_t peak_bytes = 0;                   ///< largest resident memory of the process so far
  std::uint64_t facets = 0, points = 0, envelope_points = 0, warnings = 0;
  std::uint64_t cl_points = 0,
                directions = 0;   ///< of the mode free: where one was sought, and how many were tested
  std::vector<StageTime> stages;  ///< of those seconds
};

/// The job as the workload changes it.
Result<Job> load(const Workload& work);
/// The frame whose axis is everywhere what `axis` is on the line from its origin along n.
AxisFrame fixed_frame(const AxisFrame& axis);

struct Outcome {
  Sample sample;
  CheckedMesh part;
  Plan plan;
};
/// In this process.
Result<Outcome> stl_to_path(const Job& job, int threads);

/// Runs this program again with `arguments` and returns what it printed. Errors: kIo with its exit status.
Result<std::string> run_apart(const std::vector<std::string>& arguments);

/// In a process of its own. Requires: main() calls serve().
Result<Sample> measure_apart(const Workload& work);
/// Is this such a process? Then its exit status.
bool serve(int argc, char** argv, int& status);

/// The bare z-map (z_map.h) of the whole file, likewise: times, memory, and its columns as points.
Result<Sample> measure_z_map_apart(const std::string& stl, double radius, double step);

/// A formula part as an STL file in `folder`, made if it is not there; `facets`: of a finer tyre or of a
/// height field, or 0.
Result<std::string> part_file(const std::string& folder, const std::string& part, std::size_t facets = 0);

}  // namespace tiltfeed::bench
