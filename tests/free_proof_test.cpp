// Paths of free orientation held against the true solids, and against what brute force says the tool can
// reach. The formula parts always; public models where their files are.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>

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

struct Case {
  std::string name;  ///< of a formula part, or of a public model
  double unit_mm = 1.0;
  Cutter cutter;
  double side_step = 1.0;
  std::vector<Vec3> planes;
  int points = 1000;
};

std::string model_file(const std::string& name) {
  return SOURCE_DIR "/../shared/models/public/" + name + ".stl";
}
bool is_formula(const std::string& name) { return name == "sphere" || name == "handle"; }

/// A ball end mill with a shank a little thinner and a holder.
Cutter tool(double ball, double reach, double holder) {
  Cutter c{ball, reach + 80, reach};
  c.cutting_length = 2 * ball, c.shank_diameter = 0.9 * ball;
  c.holder = {{holder, holder, 30}};
  return c;
}

std::vector<Case> cases() {
  const Vec3 x{1, 0, 0}, z{0, 0, 1};
  std::vector<Case> all{
      {"sphere", 1, tool(10, 90, 30), 2.0, {z, x}, 1000},
      {"handle", 1, tool(6, 60, 25), 1.5, {x, z}, 1000},
      {"propeller_d", 1, tool(3, 50, 20), 1.0, {z, x}, 1000},
      {"impeller_aero", 1, tool(2, 40, 20), 1.0, {z, x}, 1000},
      {"knob_shifter", 1, tool(5, 60, 25), 1.5, {z, x}, 1000},
      {"tooth_molar", 1, tool(1, 20, 10), 0.3, {z, x}, 1000},
      {"femur", 1, tool(10, 90, 40), 4.0, {z, x}, 1000},
      {"blade_nasa", 1000, tool(3, 50, 20), 0.8, {z, x}, 1000},
  };
  std::erase_if(
      all, [](const Case& c) { return !is_formula(c.name) && !std::filesystem::exists(model_file(c.name)); });
  return all;
}

Result<CheckedMesh> load(const Case& c) {
  Stl stl;
  if (is_formula(c.name)) {
    stl.facets = *sim::part_by_name(c.name);
  } else {
    auto read = read_stl(model_file(c.name), c.unit_mm);
    if (!read) return tl::unexpected(read.error());
    stl = std::move(*read);
  }
  return check_mesh(stl);
}

PlanOptions options_for(const Case& c) {
  PlanOptions o;
  o.name = c.name, o.cutter = c.cutter, o.tolerance = kTolerance;
  o.axis.mode = AxisMode::kFree;
  o.free.plane_normals = c.planes, o.free.lead = Angle::from_degrees(10.0);
  o.free.smoothing = c.cutter.radius(), o.free.max_turn = Angle::from_degrees(5.0);
  o.pattern.side_step = c.side_step;
  o.holder.clearance = 0.5;
  o.links.clearance = 5, o.links.approach = 1;
  o.cut_feed = Feed::from_mm_per_min(2000), o.plunge_feed = Feed::from_mm_per_min(600);
  return o;
}

class FreeProof : public ::testing::TestWithParam<Case> {};

TEST_P(FreeProof, IsClearInContactAndComplete) {
  const Case& c = GetParam();
  const auto part = load(c);
  ASSERT_TRUE(part) << part.error().message;
  const PlanOptions o = options_for(c);
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
  const FreeCoverage k =
      FreeCover(part->mesh, distances, reach, c.planes, PassStep::kPlanes, c.side_step, kTolerance)
          .cover(path, c.points);
  std::printf(
      "%s: %zu facets, plan %.2f s, %zu moves, %llu breaks; %zu + %zu poses: gouge cut %.4f %.4f %.4f, link "
      "%.4f %.4f "
      "%.4f, contact %.4f; cover %.4f of %zu (border %zu, shallow %zu), no seat %zu, no direction %zu\n",
      c.name.c_str(), part->mesh.facets.size(), seconds, path.moves.size(),
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
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace tiltfeed
