// Pencil passes through plan(): on the crease, in every axis field, and never in the part.
#include "pathgen/pattern/pencil.h"

#include <gtest/gtest.h>

#include "tests/shapes/box_mesh.h"
#include "tests/shapes/cut_passes.h"
#include "tests/shapes/valley_block.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

PlanOptions pencil_options(const AxisFrame& axis, double diameter) {
  PlanOptions o = options_with(axis);
  o.cutter.diameter = diameter;
  o.pattern.kind = PatternKind::kPencil;
  o.pattern.side_step = 0.0;
  o.tolerance = 0.01;
  return o;
}

/// The centres of the ball on cutting moves, and places between them.
std::vector<std::vector<Point<Part>>> ball_ways(const std::vector<Move>& moves, double radius) {
  std::vector<std::vector<Point<Part>>> ways;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    if (moves[i].kind != MoveKind::kCut) continue;
    if (moves[i - 1].kind != MoveKind::kCut) ways.emplace_back();
    const auto centre = [&](const Move& m) { return m.pose.tip + m.pose.axis * radius; };
    for (int k = 0; k <= 8; ++k) ways.back().push_back(lerp(centre(moves[i - 1]), centre(moves[i]), k / 8.0));
  }
  return ways;
}

TEST(Pencil, FollowsTheCreaseOfAValleyInEveryMode) {
  for (const double degrees : {35.0, 45.0, 60.0})
    for (const AxisFrame& frame : frames_over_a_valley()) {
      const double half = degrees / 180.0 * kPi, r = 1.5;
      const auto planned = plan(valley_block(half), pencil_options(frame, 2.0 * r), {});
      ASSERT_TRUE(planned) << planned.error().message;
      double length = 0.0;
      for (const auto& way : ball_ways(planned->path.moves, r))
        for (std::size_t i = 0; i < way.size(); ++i) {
          const Point<Part> c = way[i];
          if (std::abs(c.y) > kHalfLength - 0.5) continue;
          // Over the edge of the valley by r / sin(half), within the tolerance to all sides.
          EXPECT_NEAR(c.x, 0.0, 0.01) << degrees << ' ' << static_cast<int>(frame.mode);
          EXPECT_NEAR(c.z, r / std::sin(half), 0.01 / std::sin(half))
              << degrees << ' ' << static_cast<int>(frame.mode);
          // Both walls keep off.
          EXPECT_GT(c.z * std::sin(half) - std::abs(c.x) * std::cos(half), r - 0.01);
          if (i > 0) length += distance(way[i - 1], c);
        }
      EXPECT_NEAR(length, 2.0 * kHalfLength - 1.0, 0.6) << degrees << ' ' << static_cast<int>(frame.mode);
    }
}

TEST(Pencil, GoesRoundABoxAtItsFootAndStaysThere) {
  CheckedMesh part;
  part.mesh = box_mesh({{Vec3{-20, -20, -5}, Vec3{20, 20, 0}}, {Vec3{-6, -4, 0}, Vec3{6, 4, 8}}});
  Stl stl;
  for (const auto& f : part.mesh.facets)
    stl.facets.push_back({part.mesh.vertices[f[0]], part.mesh.vertices[f[1]], part.mesh.vertices[f[2]]});
  const auto checked = check_mesh(stl);
  ASSERT_TRUE(checked) << checked.error().message;
  for (const CutterType type : {CutterType::kBall, CutterType::kFlat}) {
    PlanOptions o = pencil_options(kUpright, 3.0);
    o.cutter.type = type;
    const auto planned = plan(*checked, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    double length = 0.0;
    for (std::size_t i = 1; i < planned->path.moves.size(); ++i) {
      if (planned->path.moves[i].kind != MoveKind::kCut) continue;
      const Point<Part> p = planned->path.moves[i].pose.tip;
      EXPECT_NEAR(p.z, 0.0, 0.01);
      const double off = std::hypot(std::max(std::abs(p.x) - 6.0, 0.0), std::max(std::abs(p.y) - 4.0, 0.0));
      EXPECT_NEAR(off, 1.5, 0.01);
      EXPECT_GT(off, 1.5 - 0.005);
      length += distance(planned->path.moves[i - 1].pose.tip, p);
    }
    EXPECT_NEAR(length, 2.0 * (12.0 + 8.0) + 2.0 * kPi * 1.5, 0.1);
  }
}

TEST(Pencil, SaysWhereThereIsNoCrease) {
  const CheckedMesh dome = turned({{0, 8}, {5, 5}, {8, 0}, {0, 0}}, 60);
  const auto planned = plan(dome, pencil_options(kUpright, 3.0), {});
  ASSERT_FALSE(planned);
  EXPECT_NE(planned.error().message.find("no crease"), std::string::npos) << planned.error().message;
  EXPECT_NE(planned.error().message.find("pattern.crease_angle_deg"), std::string::npos);
}

}  // namespace
}  // namespace tiltfeed
