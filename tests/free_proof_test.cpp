// Paths of free orientation held against the true solids, and against what brute force says the tool can
// reach. The formula parts always; public models where their files are.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "config/job.h"
#include "pathgen/plan.h"
#include "pathgen/stl.h"
#include "sim/parts.h"
#include "tests/free_cover.h"
#include "tests/tool_proof.h"

namespace tiltfeed {
namespace {

constexpr double kTolerance = 0.01;
constexpr double kSpacing = 0.05;  ///< of the poses on cuts, mm
constexpr double kLeastCover = 0.99;

constexpr int kSurfacePoints = 1000;

bool is_formula(const std::string& name) { return name == "sphere" || name == "handle"; }

Result<Job> job_of(const std::string& name) {
  return load_job(SOURCE_DIR "/tests/jobs/free/" + name + ".yaml");
}

/// Those whose part is there.
std::vector<std::string> cases() {
  std::vector<std::string> all{"sphere", "handle",      "knob_shifter", "tooth_molar",
                               "femur",  "propeller_d", "blade_nasa"};
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

class FreeProof : public ::testing::TestWithParam<std::string> {};

TEST_P(FreeProof, IsClearInContactAndComplete) {
  const std::string& name = GetParam();
  const auto job = job_of(name);
  ASSERT_TRUE(job) << job.error().message;
  const PlanOptions& o = job->plan;
  const auto part = load(name, *job);
  ASSERT_TRUE(part) << part.error().message;
  const auto start = std::chrono::steady_clock::now();
  const auto planned = plan(*part, o, {});
  ASSERT_TRUE(planned) << planned.error().message;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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
                             .cover(path, kSurfacePoints);
  std::printf(
      "%s: %zu facets, plan %.2f s, %zu moves, %llu breaks; %zu + %zu poses: gouge cut %.4f %.4f %.4f, link "
      "%.4f %.4f "
      "%.4f, contact %.4f; cover %.4f of %zu (border %zu, shallow %zu), no seat %zu, no direction %zu\n",
      name.c_str(), part->mesh.facets.size(), seconds, path.moves.size(),
      static_cast<unsigned long long>(planned->report.free ? planned->report.free->breaks : 0),
      found.cut_poses, found.link_poses, found.cut[0].value, found.cut[1].value, found.cut[2].value,
      found.link[0].value, found.link[1].value, found.link[2].value, found.contact.value, k.share(),
      k.reachable, k.border, k.shallow, k.no_seat, k.no_direction);
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
  EXPECT_GT(k.reachable, 100u);
  EXPECT_GE(k.share(), kLeastCover) << k.worst_excess << " at " << k.worst_at.x << ", " << k.worst_at.y
                                    << ", " << k.worst_at.z;
  EXPECT_LE(k.border + k.shallow, k.reachable / 50);
}

INSTANTIATE_TEST_SUITE_P(Parts, FreeProof, ::testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param; });

}  // namespace
}  // namespace tiltfeed
