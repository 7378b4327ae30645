// The stages together: closed forms on a sphere and a torus, the same path for a moved or shuffled mesh and
// for any number of threads, clear rapids, cancelling, and an answer for what cannot be planned.
#include "pathgen/plan/plan.h"
#include "pathgen/mesh/mesh_check.h"
#include "tests/shapes/cut_passes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <vector>

#include "kinematics/basics/units.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// A closed grid of points, columns by rows, both wound round; `at(i, j)` gives the points.
template <class Function>
CheckedMesh wound(int columns, int rows, Function at) {
  CheckedMesh part;
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j)
      part.mesh.vertices.push_back(at(2 * kPi * i / columns, 2 * kPi * j / rows));
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>((i % columns) * rows + j % rows); };
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      part.mesh.facets.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      part.mesh.facets.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) part.mesh.source.push_back(f);
  return part;
}

void turn_over(CheckedMesh& part) {
  for (auto& f : part.mesh.facets) std::swap(f[1], f[2]);
}

/// Torus round the z axis, normals outwards.
CheckedMesh torus(double ring, double tube, int columns = 96, int rows = 64) {
  CheckedMesh part = wound(columns, rows, [&](double u, double v) {
    const double r = ring + tube * std::cos(v);
    return Point<Part>{r * std::cos(u), r * std::sin(u), tube * std::sin(v)};
  });
  return part;
}

/// A sphere round the origin: an octahedron, its facets split and put on the sphere.
CheckedMesh sphere(double radius, int splits) {
  std::vector<std::array<Vec3, 3>> facets;
  for (int i = 0; i < 8; ++i) {
    const double x = i & 1 ? -1 : 1, y = i & 2 ? -1 : 1, z = i & 4 ? -1 : 1;
    if (x * y * z > 0)
      facets.push_back({Vec3{x, 0, 0}, Vec3{0, y, 0}, Vec3{0, 0, z}});
    else
      facets.push_back({Vec3{0, y, 0}, Vec3{x, 0, 0}, Vec3{0, 0, z}});
  }
  for (int s = 0; s < splits; ++s) {
    std::vector<std::array<Vec3, 3>> finer;
    for (const auto& [a, b, c] : facets) {
      const Vec3 ab = normalized(a + b), bc = normalized(b + c), ca = normalized(c + a);
      for (const auto& t : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.push_back(t);
    }
    facets = finer;
  }
  Stl stl;
  for (const auto& t : facets) {
    stl.facets.push_back({});
    for (std::size_t i = 0; i < 3; ++i) stl.facets.back()[i] = Point<Part>{} + t[i] * radius;
  }
  return *check_mesh(stl);
}

TEST(Plan, TipsLieOnASphereAndAxesPointOutwards) {
  const double radius = 25.0;
  const CheckedMesh part = sphere(radius, 4);
  ASSERT_EQ(part.sides, Sides::kOutward);
  double sag = 0.0;  // how far the flattest facet cuts into the sphere
  for (const auto& f : part.mesh.facets) {
    const auto& v = part.mesh.vertices;
    const Vec3 n = normalized(cross(v[f[1]] - v[f[0]], v[f[2]] - v[f[0]]));
    sag = std::max(sag, radius - dot(n, from_origin(v[f[0]])));
  }
  ASSERT_LT(sag, 0.1);
  for (double allowance : {0.0, 0.5})
    for (Along along : {Along::kX, Along::kY}) {
      PlanOptions o = options_with(kPointFrame);
      o.allowance = allowance;
      o.pattern.along = along;
      const auto planned = plan(part, o, nullptr);
      ASSERT_TRUE(planned) << planned.error().message;
      ASSERT_GT(planned->report.points, 500u);
      for (const Move& m : planned->path.moves) {
        const double r = length(from_origin(m.pose.tip));
        EXPECT_LT(length(m.pose.axis - normalized(from_origin(m.pose.tip))), 1e-9);
        if (m.kind == MoveKind::kRapid) {
          EXPECT_GT(r, radius - sag + allowance);
        } else {
          EXPECT_NEAR(r, radius + allowance, sag + o.tolerance);
          EXPECT_LT(m.facet, part.mesh.facets.size());
        }
      }
    }
}

TEST(Plan, RapidsStayOutsideTheClearanceSurfaceWhileTravelling) {
  const CheckedMesh part = torus(60.0, 15.0);
  const PlanOptions o = options_with(kRing);
  const auto planned = plan(part, o, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  const auto& moves = planned->path.moves;
  const auto rho = [](Point<Part> p) { return std::hypot(std::hypot(p.x, p.y) - 60.0, p.z); };
  int travels = 0;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    if (moves[i].kind != MoveKind::kRapid || moves[i - 1].kind != MoveKind::kRapid) continue;
    if (angle_between(moves[i].pose.axis, moves[i - 1].pose.axis) < 1e-6)
      continue;  // up or down along the axis
    ++travels;
    for (double f : {0.0, 0.25, 0.5, 0.75, 1.0})
      EXPECT_GT(rho(lerp(moves[i - 1].pose.tip, moves[i].pose.tip, f)), 15.0 + 0.85 * o.links.clearance);
  }
  EXPECT_GT(travels, 10);
}

/// Largest distance between the moves of two paths, one after the other; infinite when they differ in number
/// or kind.
double difference(const ToolPath& a, const ToolPath& b, const Rotation& turn, Vec3 shift) {
  if (a.moves.size() != b.moves.size()) return std::numeric_limits<double>::infinity();
  double worst = 0.0;
  for (std::size_t i = 0; i < a.moves.size(); ++i) {
    if (a.moves[i].kind != b.moves[i].kind) return std::numeric_limits<double>::infinity();
    const Vec3 tip = turn * from_origin(a.moves[i].pose.tip) + shift;
    worst = std::max(worst, length(tip - from_origin(b.moves[i].pose.tip)));
    worst = std::max(worst, length(turn * a.moves[i].pose.axis - b.moves[i].pose.axis));
  }
  return worst;
}

/// A torus whose tube is thick and thin, so that nothing of it is symmetrical.
CheckedMesh uneven_torus() {
  return wound(40, 24, [](double u, double v) {
    const double tube = 14.0 + 2.0 * std::sin(3 * u + 0.3) * std::cos(2 * v + 0.9) + 1.3 * std::cos(u - v);
    const double r = 60.0 + tube * std::cos(v);
    return Point<Part>{r * std::cos(u), r * std::sin(u), tube * std::sin(v)};
  });
}

TEST(Plan, AMovedPartGivesTheMovedPath) {
  const CheckedMesh part = uneven_torus();
  const auto straight = plan(part, options_with(kRing), nullptr);
  ASSERT_TRUE(straight);
  const Rotation turn = rotation_about(normalized(Vec3{1, 2, 3}), 0.7);
  const Vec3 shift{120.0, -45.0, 8.0};
  CheckedMesh moved = part;
  for (auto& v : moved.mesh.vertices) v = Point<Part>{} + (turn * from_origin(v) + shift);
  AxisFrame frame = kRing;
  frame.origin = Point<Part>{} + shift;
  frame.t = turn * frame.t, frame.n = turn * frame.n;
  const auto there = plan(moved, options_with(frame), nullptr);
  ASSERT_TRUE(there);
  EXPECT_LT(difference(straight->path, there->path, turn, shift), 1e-6);
}

/// Largest distance of every 30th cutting tip of `a` from the cutting moves of `b`.
double stray(const ToolPath& a, const ToolPath& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.moves.size(); i += 30) {
    if (a.moves[i].kind != MoveKind::kCut) continue;
    const Point<Part> p = a.moves[i].pose.tip;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 1; j < b.moves.size(); ++j) {
      if (b.moves[j].kind != MoveKind::kCut) continue;
      const Point<Part> from = b.moves[j - 1].pose.tip;
      const Vec3 d = b.moves[j].pose.tip - from;
      const double f =
          squared_length(d) > 0.0 ? std::clamp(dot(p - from, d) / squared_length(d), 0.0, 1.0) : 0.0;
      nearest = std::min(nearest, distance(p, from + d * f));
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

TEST(Plan, ShuffledFacetsGiveTheSamePath) {
  const CheckedMesh part = uneven_torus();
  CheckedMesh shuffled = part;
  std::mt19937 random(5);
  std::shuffle(shuffled.mesh.facets.begin(), shuffled.mesh.facets.end(), random);
  for (auto& f : shuffled.mesh.facets) std::rotate(f.begin(), f.begin() + random() % 3, f.end());
  const auto a = plan(part, options_with(kRing), nullptr), b = plan(shuffled, options_with(kRing), nullptr);
  ASSERT_TRUE(a && b);
  // Where patches meet, rounding decides which of two equal heights is taken, and so which points are
  // dropped.
  const double tolerance = options_with(kRing).tolerance;
  EXPECT_LT(stray(a->path, b->path), tolerance);
  EXPECT_LT(stray(b->path, a->path), tolerance);
  EXPECT_EQ(a->report.passes, b->report.passes);
  EXPECT_NEAR(a->report.cut_length, b->report.cut_length, 1e-5 * a->report.cut_length);
}

TEST(Plan, AnyNumberOfThreadsGivesTheSameBits) {
  const CheckedMesh part = uneven_torus();
  const auto many = plan(part, options_with(kRing), nullptr);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = plan(part, options_with(kRing), nullptr);
  ASSERT_TRUE(many && single);
  EXPECT_EQ(difference(many->path, single->path, Rotation{}, Vec3{}), 0.0);
}

TEST(Plan, ZigzagTurnsEverySecondPassRound) {
  const CheckedMesh part = sphere(25.0, 3);
  PlanOptions o = options_with(kPointFrame);
  const auto passes_rising = [&](Direction direction) {
    o.pattern.direction = direction;
    const auto planned = plan(part, o, nullptr);
    std::vector<bool> rising;
    const auto& moves = planned->path.moves;
    const Deformation map(kPointFrame, 1.0);
    for (std::size_t i = 0; i + 1 < moves.size(); ++i)
      if (moves[i].kind == MoveKind::kPlunge && moves[i + 1].kind == MoveKind::kCut)
        rising.push_back(map.flatten(moves[i + 1].pose.tip).x > map.flatten(moves[i].pose.tip).x);
    return rising;
  };
  const auto one_way = passes_rising(Direction::kOneWay), zigzag = passes_rising(Direction::kZigzag);
  ASSERT_GT(one_way.size(), 10u);
  for (bool r : one_way) EXPECT_TRUE(r);
  for (std::size_t i = 0; i < zigzag.size(); ++i) EXPECT_EQ(zigzag[i], i % 2 == 0) << i;
}

TEST(Plan, AShankThatWouldHitTheFarWallIsRefused) {
  CheckedMesh cavity = torus(60.0, 20.0);
  turn_over(cavity);
  AxisFrame frame = kRing;
  frame.sense = Sense::kInward;
  PlanOptions o = options_with(frame);
  o.cutter.shank_length = 35.0;  // tip on one wall, 40 mm from the other
  o.links.clearance = 2.0;
  const auto fits = plan(cavity, o, nullptr);
  ASSERT_TRUE(fits) << fits.error().message;
  EXPECT_TRUE(fits->report.warnings.empty()) << fits->report.warnings.front();
  o.cutter.shank_length = 45.0;
  const auto hits = plan(cavity, o, nullptr);
  ASSERT_FALSE(hits);
  EXPECT_EQ(hits.error().code, Code::kGouge);
}

TEST(Plan, OutsideWorkInTheRingsHoleMindsTheFarSide) {
  const CheckedMesh part = torus(20.0, 6.0);  // a hole 28 mm wide
  AxisFrame frame = kRing;
  frame.circle_radius = 20.0;
  PlanOptions o = options_with(frame);
  o.links.clearance = 3.0;
  o.cutter.shank_length = 20.0;  // shorter than the hole is wide, retracted too
  const auto fits = plan(part, o, nullptr);
  ASSERT_TRUE(fits) << fits.error().message;
  EXPECT_TRUE(fits->report.warnings.empty());
  o.cutter.shank_length = 40.0;
  const auto trimmed = plan(part, o, nullptr);
  ASSERT_TRUE(trimmed) << trimmed.error().message;
  EXPECT_FALSE(trimmed->report.warnings.empty());
  EXPECT_LT(trimmed->report.cut_length, fits->report.cut_length);
  for (const Move& m : trimmed->path.moves)  // nowhere is the shank inside the tube, grown by its radius
    for (double up = o.cutter.radius(); up <= 40.0 - o.cutter.radius(); up += 0.5) {
      const Point<Part> p = m.pose.tip + m.pose.axis * up;
      EXPECT_GT(std::hypot(std::hypot(p.x, p.y) - 20.0, p.z), 6.0 + o.cutter.radius() - 0.1);
    }
}

TEST(Plan, APartlyBlockedCavityIsTrimmedWithAWarning) {
  CheckedMesh cavity = torus(60.0, 20.0);
  turn_over(cavity);
  std::erase_if(cavity.mesh.facets, [&](const auto& f) {  // the ring's inner half is open
    const Point<Part> p = cavity.mesh.vertices[f[0]];
    return std::hypot(p.x, p.y) < 60.0;
  });
  cavity.mesh.source.resize(cavity.mesh.facets.size());
  cavity.sides = Sides::kBoth;
  AxisFrame frame = kRing;
  frame.sense = Sense::kInward;
  PlanOptions o = options_with(frame);
  o.links.clearance = 2.0;
  o.cutter.shank_length = 60.0;
  const auto planned = plan(cavity, o, nullptr);
  ASSERT_TRUE(planned) << planned.error().message;
  ASSERT_GE(planned->report.warnings.size(), 1u);
  EXPECT_NE(planned->report.warnings[0].find("shank"), std::string::npos);
}

TEST(Plan, WhatNeedsMoreTiltIsLeftOut) {
  const CheckedMesh part = sphere(25.0, 3);
  PlanOptions o = options_with(kPointFrame);
  const auto whole = plan(part, o, nullptr);
  o.up = normalized(Vec3{1, 2, -1});
  o.tilt_max = Angle::from_degrees(60.0);
  const auto planned = plan(part, o, nullptr);
  ASSERT_TRUE(whole && planned);
  ASSERT_EQ(planned->report.warnings.size(), 1u);
  double widest = 0.0;
  for (const Move& m : planned->path.moves)
    if (m.kind == MoveKind::kCut) widest = std::max(widest, angle_between(m.pose.axis, o.up));
  EXPECT_LE(widest, o.tilt_max.radians());
  EXPECT_GT(widest, Angle::from_degrees(57.0).radians());
  // A cap of 60 degrees is a quarter of a sphere, and so of the length of evenly spaced passes, nearly.
  EXPECT_NEAR(planned->report.cut_length / whole->report.cut_length, 0.25, 0.06);
  o.tilt_max = Angle::from_degrees(0.01);
  const auto nothing = plan(part, o, nullptr);
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().code, Code::kLimit);
}

TEST(Plan, CancelsWhenTheUserSaysSo) {
  const CheckedMesh part = uneven_torus();
  int calls = 0;
  const auto planned = plan(part, options_with(kRing), [&](const char*, double) { return ++calls < 4; });
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().code, Code::kCancelled);
  EXPECT_EQ(calls, 4);
}

TEST(Plan, WhereTheLinePiercesThePartItSaysSoAndPlansTheRest) {
  const CheckedMesh part = sphere(25.0, 3);
  PlanOptions o = options_with({AxisMode::kLine, Sense::kOutward, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 0.0});
  for (Along along : {Along::kX, Along::kY}) {
    o.pattern.along = along;
    const auto planned = plan(part, o, nullptr);
    ASSERT_TRUE(planned) << planned.error().message;
    if (along == Along::kX) {  // these passes run over the poles
      ASSERT_EQ(planned->report.warnings.size(), 1u);
      EXPECT_NE(planned->report.warnings[0].find("touches the axis"), std::string::npos);
    }
    double top = 0.0;
    for (const Move& m : planned->path.moves) top = std::max(top, m.pose.tip.z);
    EXPECT_GT(top, along == Along::kX ? 26.5 : 25.0);
  }
}

TEST(Plan, AnswersWhatCannotBePlanned) {
  const CheckedMesh part = torus(60.0, 15.0);
  PlanOptions o = options_with(kRing);
  const auto code = [&] {
    const auto planned = plan(part, o, nullptr);
    EXPECT_FALSE(planned);
    return planned ? Code::kIo : planned.error().code;
  };
  o.axis.sense = Sense::kInward;  // the torus turns its back to its own circle
  EXPECT_EQ(code(), Code::kUnreachable);
  o = options_with(kRing);
  o.pattern.side_step = 1e-6;  // too many passes
  EXPECT_EQ(code(), Code::kLimit);
  o.pattern.side_step = 3e-4;  // too many cuts of facets
  EXPECT_EQ(code(), Code::kLimit);
  for (double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    o = options_with(kRing), o.pattern.side_step = bad;
    EXPECT_EQ(code(), Code::kInput);
    o = options_with(kRing), o.tolerance = bad;
    EXPECT_EQ(code(), Code::kInput);
    o = options_with(kRing), o.cutter.diameter = bad;
    EXPECT_EQ(code(), Code::kInput);
    o = options_with(kRing), o.links.clearance = bad;
    EXPECT_EQ(code(), Code::kInput);
  }
}

TEST(Plan, AClearanceThatReachesTheCircleIsRefused) {
  CheckedMesh cavity = torus(60.0, 20.0);
  turn_over(cavity);
  PlanOptions o = options_with(kRing);
  o.axis.sense = Sense::kInward;
  o.cutter.shank_length = 30.0;
  o.links.clearance = 19.0;
  const auto planned = plan(cavity, o, nullptr);
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().code, Code::kLimit);
}

}  // namespace
}  // namespace tiltfeed
