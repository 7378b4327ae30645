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
#include <random>

#include "pathgen/plan.h"
#include "pathgen/stl.h"
#include "sim/distance.h"
#include "sim/parts.h"
#include "tests/path_proof.h"

namespace tiltfeed {
namespace {

using sim::Hit;
using sim::kInfinity;
using sim::PartDistance;

constexpr double kTolerance = 0.01;
constexpr std::size_t kLeastPoses = 150'000;
constexpr int kSurfacePoints = 20'000;
// A ball placed on a facet's normal is off by the rounding of its coordinates, mm.
constexpr double kRounding = 1e-6;
// Walls steeper than 85 degrees against the axis are counted as steep.
constexpr double kLeastFacing = 0.0872;

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

struct Coverage {
  std::size_t points = 0;  ///< reachable, between two passes
  std::size_t steep = 0;   ///< of these: where passes are further apart along the wall than the radius
  std::size_t tight =
      0;  ///< of the others: within the scallop of the distance to the nearer pass, on a plane
  std::size_t unreachable = 0, outside = 0;
  std::size_t uncut = 0;  ///< more left than the two passes beside it must leave, by over the tolerance
  double worst_excess = -kInfinity;
  Point<Part> worst_at;
};

/// No reachable point of the part keeps more material than the two passes beside it must leave.
class CoverProof {
 public:
  CoverProof(const Case& c, const CheckedMesh& checked, const ToolPath& path, const PathProof& proof)
      : case_(c),
        mesh_(checked.mesh),
        path_(path),
        proof_(proof),
        part_(proof.part()),
        radius_(c.cutter.radius()),
        map_(proof.map()) {}

  Coverage cover() const;

 private:
  double across(Point<Flat> f) const { return case_.along == Along::kX ? f.y : f.x; }
  std::vector<double> pass_places() const;
  double left_bound(double gap, double slope_cosine) const {
    const double l = gap / slope_cosine;
    return std::sqrt(radius_ * radius_ + l * l) - radius_;
  }
  bool reachable(Point<Part> centre, Vec3 axis) const;
  double left_by_pass(Point<Part> p, Point<Flat> flat, double place) const;
  void cover_point(Point<Part> p, Vec3 normal, const std::vector<double>& places, const PartDistance& swept,
                   Coverage& c) const;

  const Case& case_;
  const Mesh& mesh_;
  const ToolPath& path_;
  const PathProof& proof_;
  const PartDistance& part_;
  double radius_;
  const Deformation& map_;
};

/// Where the passes lie, in flat coordinates of this test's own scale, ascending.
std::vector<double> CoverProof::pass_places() const {
  std::vector<double> places, distinct;
  for (const Move& move : path_.moves)
    if (move.kind == MoveKind::kCut)
      places.push_back(across(map_.flatten(move.pose.tip + move.pose.axis * radius_)));
  std::sort(places.begin(), places.end());
  for (const double p : places)
    if (distinct.empty() || p > distinct.back() + 1e-7) distinct.push_back(p);
  return distinct;
}

/// The tool can stand there: nothing in the way of ball and shank, up to the axis feature or out of the part.
bool CoverProof::reachable(Point<Part> centre, Vec3 axis) const {
  const Hit hit = part_.nearest({centre, centre + axis * proof_.way_out(centre)}, radius_ - kRounding);
  return hit.facet == kNoFacet;
}

void CoverProof::cover_point(Point<Part> p, Vec3 normal, const std::vector<double>& places,
                             const PartDistance& swept, Coverage& c) const {
  const Point<Part> centre = p + normal * radius_;
  const Vec3 axis = map_.axis_at(centre);
  if (!reachable(centre, axis)) return void(++c.unreachable);
  const Point<Flat> flat = map_.flatten(centre);
  const auto above = std::lower_bound(places.begin(), places.end(), across(flat));
  if (above == places.begin() || above == places.end()) return void(++c.outside);
  // A small step across the passes shows their direction and true distance there.
  constexpr double kStep = 1e-5;
  const Point<Flat> beside = case_.along == Along::kX ? Point<Flat>{flat.x, flat.y + kStep, flat.z}
                                                      : Point<Flat>{flat.x + kStep, flat.y, flat.z};
  const Vec3 sideways = map_.unflatten(beside) - map_.unflatten(flat);
  const double true_length = length(sideways) / kStep;
  const double facing = std::abs(dot(axis, normal));
  const double slope_cosine = facing / std::hypot(facing, dot(normalized(sideways), normal));
  const double below_gap = (across(flat) - above[-1]) * true_length,
               above_gap = (*above - across(flat)) * true_length;
  const double must_leave = std::min(left_by_pass(p, flat, above[-1]), left_by_pass(p, flat, *above));
  if (must_leave == kInfinity) return void(++c.outside);
  ++c.points;
  const double left = swept.nearest(p).value - radius_;
  const double near = std::min(below_gap, above_gap);
  if (facing < kLeastFacing || near / slope_cosine > radius_) {
    ++c.steep;
  } else if (left <= left_bound(near, slope_cosine) + kTolerance) {
    ++c.tight;
  }
  const double excess = left - must_leave - kTolerance;
  if (excess > c.worst_excess) c.worst_excess = excess, c.worst_at = p;
  if (excess > 0.0) ++c.uncut;
}

/// What a ball leaves at p when it stands on the true envelope (let down from beyond the part) beside it,
/// where a pass lies at `place` across; infinite if there is nothing to stand on.
double CoverProof::left_by_pass(Point<Part> p, Point<Flat> flat, double place) const {
  const bool x = case_.along == Along::kX;
  const AxisLine line = map_.axis_line(x ? flat.x : place, x ? place : flat.y);
  const Point<Part> level = line.base + line.axis * flat.z;
  const Point<Part> start = level + line.axis * proof_.way_out(level);
  const Hit drop = part_.first_touch(start, -line.axis, radius_);
  if (drop.value == kInfinity) return kInfinity;
  return distance(p, start - line.axis * drop.value) - radius_;
}

Coverage CoverProof::cover() const {
  // The track of the ball's centre, as facets without area, which count by their edges.
  Mesh track;
  for (std::size_t i = 0; i < path_.moves.size(); ++i) {
    const Pose& pose = path_.moves[i].pose;
    track.vertices.push_back(pose.tip + pose.axis * radius_);
    const auto v = static_cast<std::uint32_t>(i);
    if (path_.moves[i].kind == MoveKind::kCut) track.facets.push_back({v - 1, v, v});
  }
  const PartDistance swept(track);
  const std::vector<double> places = pass_places();
  std::vector<double> areas;
  double sum = 0.0;
  for (const auto& f : mesh_.facets) {
    const Point<Part> a = mesh_.vertices[f[0]];
    sum += 0.5 * length(cross(mesh_.vertices[f[1]] - a, mesh_.vertices[f[2]] - a));
    areas.push_back(sum);
  }
  std::mt19937_64 random(20050101);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Coverage c;
  for (int i = 0; i < kSurfacePoints; ++i) {
    const auto facet =
        static_cast<std::size_t>(std::lower_bound(areas.begin(), areas.end(), unit() * sum) - areas.begin());
    const auto& f = mesh_.facets[std::min(facet, areas.size() - 1)];
    const Point<Part> a = mesh_.vertices[f[0]];
    const Vec3 ab = mesh_.vertices[f[1]] - a, ac = mesh_.vertices[f[2]] - a;
    double v = unit(), w = unit();
    if (v + w > 1.0) v = 1.0 - v, w = 1.0 - w;
    cover_point(a + ab * v + ac * w, normalized(cross(ab, ac)), places, swept, c);
  }
  return c;
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
  options.pattern.along = c.along, options.pattern.direction = c.direction, options.pattern.side_step = c.side_step;
  options.tolerance = kTolerance, options.links.clearance = c.cutter.diameter, options.links.approach = c.cutter.radius();
  options.cut_feed = Feed::from_mm_per_min(1000), options.plunge_feed = Feed::from_mm_per_min(300);
  const auto start = std::chrono::steady_clock::now();
  const auto planned = plan(*checked, options, {});
  ASSERT_TRUE(planned) << planned.error().message;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const PathProof proof(c.axis, c.along, c.cutter, kTolerance, *checked, planned->path);
  const Measured m = proof.measure(kLeastPoses);
  const Coverage k = CoverProof(c, *checked, planned->path, proof).cover();
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

}  // namespace
}  // namespace tiltfeed
