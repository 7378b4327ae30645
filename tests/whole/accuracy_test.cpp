// Brute-force proof of planned paths. Each part is planned at a tolerance of 0.01 mm; then, with the exact
// distances of sim/ and nothing of the planner's but its map of directions, dense poses along the whole path
// are held against the part: ball and shank do not gouge, the ball stays in contact, rapids keep clear, and
// no reachable point of the part keeps more material than the two passes beside it must leave.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "tests/judges/cover_proof.h"
#include "tests/judges/path_proof.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kTolerance = 0.01;
constexpr std::size_t kLeastPoses = 150'000;
constexpr int kSurfacePoints = 20'000;

struct Case {
  std::string name;  ///< of a formula part, or of a public model
  AxisFrame axis;
  Cutter cutter;
  double side_step;
  Along along = Along::kX;
  Direction direction = Direction::kZigzag;
};

std::string model_file(const std::string& name) {
  return SOURCE_DIR "/../shared/models/public/" + name + ".stl";
}

bool is_formula(const std::string& name) { return name == "tyre" || name == "pin" || name == "sphere"; }

const double kC15 = std::cos(kPi / 12), kS15 = std::sin(kPi / 12);

/// Formula parts always; public models where their files are.
std::vector<Case> cases() {
  using enum AxisMode;
  using enum Sense;
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  std::vector<Case> all{
      {"tyre", {kCircle, kInward, {0, 0, 0}, x, -z, 280}, {2, 80, 30}, 0.8},
      {"tyre", {kCircle, kInward, {0, 0, 0}, x, -z, 280}, {2, 80, 30}, 1.0, Along::kY, Direction::kOneWay},
      {"pin", {kLine, kOutward, {0, 0, 0}, y, {kS15, 0, kC15}}, {2, 80, 30}, 0.4},
      {"pin", {kLine, kOutward, {0, 0, 0}, y, {kS15, 0, kC15}}, {2, 80, 30}, 0.4, Along::kY},
      {"sphere", {kPoint, kOutward, {0, 0, 0}, x, normalized({0, -0.57735, 0.81650})}, {10, 80, 40}, 1.5},
      {"knob_shifter", {kPoint, kOutward, {0, -5, 125}, x, z}, {4, 80, 30}, 1.0},
      {"tooth_molar", {kPoint, kOutward, {0, 24.2, -5.4}, x, z}, {1, 60, 20}, 0.1},
      {"ring_ftc11", {kCircle, kOutward, {0, 0, 0}, y, x, 29}, {2, 60, 20}, 0.3},
      {"tube_3legs", {kPoint, kOutward, {0, 0, 100}, x, z}, {10, 120, 60}, 3.0},
      {"halfdonut_solidbin", {kCircle, kOutward, {1.5, 0, 1.5}, x, -z, 1.0}, {0.2, 30, 5}, 0.01},
      {"femur", {kLine, kOutward, {-8.7, 6.8, 0}, z, x}, {6, 120, 60}, 2.0},
      {"heatsink_finpack", {kLine, kOutward, {-3, 0, -20}, y, z}, {2, 80, 30}, 1.5},
      {"wheel_in_box", {kFixed, kOutward, {0, 0, 0}, x, z}, {6, 120, 80}, 1.5},
  };
  std::erase_if(
      all, [](const Case& c) { return !is_formula(c.name) && !std::filesystem::exists(model_file(c.name)); });
  return all;
}

class Accuracy : public ::testing::TestWithParam<Case> {};

TEST_P(Accuracy, PathIsGougeFreeInContactAndComplete) {
  const Case& c = GetParam();
  Stl stl;
  if (is_formula(c.name)) {
    stl.facets = *sim::part_by_name(c.name);
  } else {
    auto read = read_stl(model_file(c.name), 1.0);
    ASSERT_TRUE(read) << read.error().message;
    stl = std::move(*read);
  }
  const auto checked = check_mesh(stl);
  ASSERT_TRUE(checked) << checked.error().message;
  PlanOptions options;
  options.name = c.name, options.cutter = c.cutter, options.axis = c.axis;
  options.pattern.along = c.along, options.pattern.direction = c.direction;
  options.pattern.side_step = c.side_step, options.tolerance = kTolerance;
  options.links.clearance = c.cutter.diameter, options.links.approach = c.cutter.radius();
  options.cut_feed = Feed::from_mm_per_min(1000), options.plunge_feed = Feed::from_mm_per_min(300);
  const auto start = std::chrono::steady_clock::now();
  const auto planned = plan(*checked, options, {});
  ASSERT_TRUE(planned) << planned.error().message;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const PathProof proof(c.axis, c.along, c.cutter, kTolerance, *checked, planned->path);
  const Measured m = proof.measure(kLeastPoses);
  const Coverage k = CoverProof(options, *checked, planned->path, proof).cover(kSurfacePoints);
  std::printf(
      "%s: plan %.2f s, %zu moves; %zu cutting poses: gouge %.5f, contact %.5f (straight drop: %zu over %.2f,"
      " largest %.3f); %zu rapid poses: overlap %.5f; %zu surface points: %.2f %% within their scallop, %zu "
      "uncut,"
      " worst %.5f; %zu steep, %zu unreachable, %zu outside\n",
      c.name.c_str(), seconds, planned->path.moves.size(), m.poses, m.gouge, m.contact, m.plain_over,
      kTolerance, m.plain_drop, m.rapid_poses, m.rapid_overlap, k.points,
      100.0 * static_cast<double>(k.tight) /
          static_cast<double>(std::max<std::size_t>(k.points - k.steep, 1)),
      k.uncut, k.worst_excess, k.steep, k.unreachable, k.outside);
  EXPECT_GE(m.poses, 100'000u);
  EXPECT_LE(m.gouge, kTolerance) << pasteable(m.gouge_at);
  EXPECT_LE(m.contact, kTolerance) << pasteable(m.contact_at);
  EXPECT_LE(m.rapid_overlap, kTolerance) << pasteable(m.rapid_at);
  EXPECT_GT(k.points, 100u);
  EXPECT_EQ(k.uncut, 0u) << k.worst_at.x << ", " << k.worst_at.y << ", " << k.worst_at.z;
}

INSTANTIATE_TEST_SUITE_P(Parts, Accuracy, ::testing::ValuesIn(cases()), [](const auto& one) {
  return one.param.name + (one.param.along == Along::kX ? "_along_x" : "_along_y");
});

/// A tyre of more facets is the same part: closed, the same box, and the volume of its curved sides.
TEST(FinerTyre, IsTheSamePart) {
  // Chords of at most 2 mm on a radius of 90 mm or more leave 0.006 mm of 60 mm of thickness and more.
  constexpr double kVolumeShare = 2e-4, kFloatRounding = 1e-4;
  // mm^3 that the cavity's chords leave standing; rounded straight middles change it by less than a tenth.
  constexpr double kLeastGain = 10.0;
  Stl coarse, fine;
  coarse.facets = sim::tyre_segment(), fine.facets = sim::tyre_segment(500'000);
  ASSERT_EQ(fine.facets.size(), 500'000u);
  const auto a = check_mesh(coarse), b = check_mesh(fine);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(b->sides, Sides::kOutward);
  EXPECT_TRUE(b->defects.empty());
  EXPECT_EQ(b->mesh.facets.size(), 500'000u);
  EXPECT_NEAR(b->volume, a->volume, kVolumeShare * a->volume);
  EXPECT_LT(b->volume, a->volume - kLeastGain) << "its cavity is no nearer to the true surface";
  EXPECT_NEAR(b->bounds.min.z, a->bounds.min.z, kFloatRounding);
  EXPECT_NEAR(b->bounds.max.x, a->bounds.max.x, kFloatRounding);
}

}  // namespace
}  // namespace tiltfeed
