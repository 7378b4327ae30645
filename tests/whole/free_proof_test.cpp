// Paths of free orientation held against the true solids, and against what brute force says the tool can
// reach. The formula parts always; public models where their files are. Prints the table of
// pathgen/free_axis/README.md.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "config/job.h"
#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "tests/judges/free_cover.h"
#include "tests/judges/over_turned.h"
#include "tests/judges/tool_proof.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

constexpr double kTolerance = 0.01;
constexpr double kSpacing = 0.05;  ///< of the poses on cuts, mm
constexpr double kLeastCover = 0.99;

/// Fewer where the judge is slow: facets like needles, or very many.
constexpr int kSurfacePoints = 500, kFewPoints = 300;

bool is_slow(const std::string& name) { return name == "blade_nasa" || name == "impeller_aero"; }

bool is_formula(const std::string& name) { return name == "sphere" || name == "handle"; }

Result<Job> job_of(const std::string& name) {
  return load_job(SOURCE_DIR "/tests/jobs/free/" + name + ".yaml");
}

/// Those whose part is there.
std::vector<std::string> cases() {
  std::vector<std::string> all{"sphere", "handle",      "knob_shifter", "tooth_molar",
                               "femur",  "propeller_d", "blade_nasa",   "impeller_aero"};
  std::erase_if(all, [](const std::string& name) {
    const auto job = job_of(name);
    return job && !is_formula(name) && !std::filesystem::exists(job->stl_path);
  });
  return all;
}

Result<CheckedMesh> load(const std::string& name, const Job& job) {
  Stl stl;
  if (is_formula(name)) {
    stl.facets = *sim::part_by_name(name);
  } else {
    auto read = read_stl(job.stl_path, job.stl_unit_mm);
    if (!read) return tl::unexpected(read.error());
    stl = std::move(*read);
  }
  return check_mesh(stl);
}

double seconds_of(const PlanReport& report, const std::string& stage) {
  for (const StageTime& time : report.times)
    if (time.stage == stage) return time.seconds;
  return 0.0;
}

/// A line of the table.
void print_row(const std::string& name, std::size_t facets, const PlanReport& report, double cpu,
               const ToolFindings& found, const FreeCoverage& cover) {
  const FreeReport& free = *report.free;
  std::printf(
      "| %s | %zu | %llu | %llu | %.2f | %llu | %.4f | %.4f | %.2f of %zu | %.2f, %.2f, %.2f | %.2f |\n",
      name.c_str(), facets, static_cast<unsigned long long>(free.cl_points),
      static_cast<unsigned long long>(free.directions), 100.0 * free.unreached_length / free.cl_length,
      static_cast<unsigned long long>(free.breaks), found.gouge(), found.contact.value, 100.0 * cover.share(),
      cover.reachable, seconds_of(report, "CL surface"), seconds_of(report, "orientation"),
      seconds_of(report, "link"), cpu);
}

class FreeProof : public ::testing::TestWithParam<std::string> {};

TEST_P(FreeProof, IsClearInContactAndComplete) {
  const std::string& name = GetParam();
  const auto job = job_of(name);
  ASSERT_TRUE(job) << job.error().message;
  const PlanOptions& o = job->plan;
  const auto part = load(name, *job);
  ASSERT_TRUE(part) << part.error().message;
  const std::clock_t start = std::clock();
  const auto planned = plan(*part, o, {});
  const double cpu = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  ASSERT_TRUE(planned) << planned.error().message;
  const ToolPath& path = planned->path;
  const sim::PartDistance distances(part->mesh);
  const std::array<double, 3> clearance{0, o.shank.clearance, o.holder.clearance};
  const ToolFindings found =
      ToolProof(distances, part->bounds, o.cutter, kTolerance, clearance).measure(path, kSpacing);
  const Reach reach(distances, part->bounds,
                    {.cutter = o.cutter,
                     .tolerance = kTolerance,
                     .clearance = clearance,
                     .up = o.up,
                     .tilt_max = o.tilt_max,
                     .directions = 500});
  const FreeCoverage k = FreeCover(part->mesh, distances, reach, o.free.plane_normals, PassStep::kPlanes,
                                   o.pattern.side_step, kTolerance)
                             .cover(path, is_slow(name) ? kFewPoints : kSurfacePoints);
  print_row(name, part->mesh.facets.size(), planned->report, cpu, found, k);
  for (const std::string& w : planned->report.warnings) std::printf("    %s\n", w.c_str());
  for (int i = 0; i < 3; ++i) {
    EXPECT_LE(found.cut[i].value, kTolerance) << sim::kToolPartNames[i] << " on the cut to move "
                                              << found.cut[i].move << ", " << pasteable(found.cut[i].at);
    EXPECT_LE(found.link[i].value, kTolerance) << sim::kToolPartNames[i] << " on the link to move "
                                               << found.link[i].move << ", " << pasteable(found.link[i].at);
  }
  EXPECT_EQ(found.buried, 0u);
  EXPECT_LE(found.contact.value, kTolerance)
      << "move " << found.contact.move << ", " << pasteable(found.contact.at);
  EXPECT_LE(over_turned(o, path.moves), 1e-6);
  EXPECT_GT(k.reachable, 100u);
  EXPECT_GE(k.share(), kLeastCover) << k.worst_excess << " at " << k.worst_at.x << ", " << k.worst_at.y
                                    << ", " << k.worst_at.z;
  EXPECT_LE(k.border + k.shallow, k.reachable / 50);
}

INSTANTIATE_TEST_SUITE_P(Parts, FreeProof, ::testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param; });

}  // namespace
}  // namespace tiltfeed
