// Rest machining: what operations before have left and cleared, by closed forms of a valley and by search.
#include "pathgen/plan/rest_wanted.h"

#include <gtest/gtest.h>

#include <random>

#include "pathgen/plan/plan.h"
#include "tests/shapes/cut_passes.h"
#include "tests/shapes/valley_block.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

PlanOptions rest_options(const AxisFrame& axis, double diameter, double step) {
  PlanOptions o = options_with(axis);
  o.cutter.diameter = diameter;
  o.pattern.along = Along::kY;
  o.pattern.side_step = step;
  o.tolerance = 0.01;
  return o;
}

std::shared_ptr<const EarlierCut> cut_before(const CheckedMesh& part, const PlanOptions& options) {
  const auto planned = plan(part, options, {});
  EXPECT_TRUE(planned) << planned.error().message;
  return std::make_shared<const EarlierCut>(EarlierCut{options, planned->path.moves});
}

/// How far the ball of radius r that touches both walls stays from a place of a wall `s` from the edge.
double left_in_corner(double r, double half, double s) {
  const double touches = r / std::tan(half);
  return s >= touches ? 0.0 : std::hypot(r, touches - s) - r;
}

TEST(RestWanted, FindsTheStripsOfAValleyThatABallLeaves) {
  for (const double degrees : {45.0, 35.0})
    for (const AxisFrame& frame : frames_over_a_valley()) {
      const double half = degrees / 180.0 * kPi, more_than = 0.15, r = 4.0;
      const CheckedMesh part = valley_block(half);
      PlanOptions o = rest_options(frame, 2.0, 0.3);
      o.rest_more_than = more_than;
      o.earlier = {cut_before(part, rest_options(frame, 2.0 * r, 0.1))};
      const auto rest = RestWanted::find(part, o, {});
      ASSERT_TRUE(rest) << rest.error().message;
      // sqrt(r^2 + (touches - s)^2) = r + more_than
      const double wide = r / std::tan(half) - std::sqrt(more_than * (2.0 * r + more_than));
      // Rows end at the sides of the block, and a cell is a third of a mm there.
      EXPECT_NEAR(rest->before().area, 2.0 * wide * 2.0 * kHalfLength, 0.12 * 4.0 * kHalfLength * 2.0)
          << degrees << ' ' << static_cast<int>(frame.mode);
      EXPECT_NEAR(rest->before().most, std::min(r, left_in_corner(r, half, 0.0)), 0.3) << degrees;
      EXPECT_LE(rest->before().most, left_in_corner(r, half, 0.0) + 0.1) << degrees;
    }
}

TEST(RestWanted, CutsAllThatIsLeftThereAndNothingFarFromIt) {
  const double half = 45.0 / 180.0 * kPi, r = 4.0, small = 1.0, more_than = 0.1;
  const CheckedMesh part = valley_block(half);
  for (const AxisFrame& frame : frames_over_a_valley()) {
    PlanOptions o = rest_options(frame, 2.0 * small, 0.25);
    const auto all = plan(part, o, {});
    ASSERT_TRUE(all) << all.error().message;
    o.rest_more_than = more_than;
    o.earlier = {cut_before(part, rest_options(frame, 2.0 * r, 0.5))};
    const auto planned = plan(part, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    ASSERT_TRUE(planned->report.rest);
    EXPECT_LT(planned->report.cut_length, 0.45 * all->report.cut_length);
    const double wide = r / std::tan(half) - std::sqrt(more_than * (2.0 * r + more_than));
    std::vector<Point<Part>> centres;
    for (const Move& m : planned->path.moves)
      if (m.kind == MoveKind::kCut) centres.push_back(m.pose.tip + m.pose.axis * small);
    for (const Point<Part>& c : centres) {
      // The place of the wall that the ball touches: the nearer of both.
      const double s = std::max(c.x * std::sin(half), -c.x * std::sin(half)) + c.z * std::cos(half);
      EXPECT_TRUE(std::abs(c.y) > kHalfLength || s < wide + 2.0) << s << " at " << c.y;
    }
    // Along the middle of the block, where left_in_corner() is over more_than and the small ball can come.
    for (double s = small / std::tan(half) + 0.02; s < wide - 0.05; s += 0.11)
      for (const double side : {-1.0, 1.0})
        for (const double y : {-9.0, 0.3, 7.1}) {
          const Point<Part> place{side * s * std::sin(half), y, s * std::cos(half)};
          double least = 1e9;
          for (std::size_t i = 1; i < planned->path.moves.size(); ++i) {
            const Move &a = planned->path.moves[i - 1], &b = planned->path.moves[i];
            if (b.kind != MoveKind::kCut) continue;
            least = std::min(least, distance_to_segment(place, a.pose.tip + a.pose.axis * small,
                                                        b.pose.tip + b.pose.axis * small) -
                                        small);
          }
          // Rows 0.25 mm apart in flat space leave ridges on walls that lean.
          EXPECT_LT(least, 0.05 + o.tolerance) << s << ' ' << y;
        }
  }
}

/// In fixed directions, after a ball that has cut with its axis along z, and after an indexed operation.
TEST(RestWanted, IndexedCutsWhatIsLeftAndNothingFarFromIt) {
  const double half = 45.0 / 180.0 * kPi, r = 6.0, small = 2.0, more_than = 0.1;
  const CheckedMesh part = valley_block(half);
  const auto indexed = [&](double diameter, double step) {
    PlanOptions o = rest_options({}, diameter, step);
    o.axis.mode = AxisMode::kIndexed;
    // Within the valley: else bottom and sides are left, too.
    o.containment.first = {-10.0, 10.0}, o.containment.height.low = 0.5;
    return o;
  };
  PlanOptions o = indexed(2.0 * small, 0.5);
  const auto all = plan(part, o, {});
  ASSERT_TRUE(all) << all.error().message;
  o.rest_more_than = more_than;
  for (const PlanOptions& before : {rest_options({}, 2.0 * r, 1.0), indexed(2.0 * r, 1.0)}) {
    SCOPED_TRACE(static_cast<int>(before.axis.mode));
    o.earlier = {cut_before(part, before)};
    const auto planned = plan(part, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    ASSERT_TRUE(planned->report.rest);
    EXPECT_LT(planned->report.cut_length, 0.6 * all->report.cut_length);
    const auto least = [&](const std::vector<Move>& moves, double radius, Point<Part> place) {
      double left = 1e9;
      for (std::size_t i = 1; i < moves.size(); ++i) {
        if (moves[i].kind != MoveKind::kCut) continue;
        const auto centre = [&](std::size_t k) { return moves[k].pose.tip + moves[k].pose.axis * radius; };
        left = std::min(left, distance_to_segment(place, centre(i - 1), centre(i)) - radius);
      }
      return left;
    };
    // On both walls, along the middle of the block.
    double farthest = 0.0;
    for (double s = small / std::tan(half) + 0.02; s < 12.0; s += 0.61)
      for (const double side : {-1.0, 1.0})
        for (const double y : {-9.0, 0.3, 7.1}) {
          const Point<Part> place{side * s * std::sin(half), y, s * std::cos(half)};
          const double left = least(o.earlier.front()->moves, r, place);
          const double now = std::min(left, least(planned->path.moves, small, place));
          if (left > more_than) {
            EXPECT_LT(now, 0.05 + o.tolerance) << s << ' ' << y;
          }
        }
    // No pose is far from where more than that is left, by search over the walls.
    for (const Move& m : planned->path.moves) {
      if (m.kind != MoveKind::kCut) continue;
      const Point<Part> c = m.pose.tip + m.pose.axis * small;
      if (std::abs(c.y) > kHalfLength - 2.0) continue;
      const double s = std::abs(c.x) * std::sin(half) + c.z * std::cos(half);
      if (s < 12.0) farthest = std::max(farthest, s);  // further up the block's side is left
    }
    const double wide = r / std::tan(half) - std::sqrt(more_than * (2.0 * r + more_than));
    EXPECT_LT(farthest, wide + 2.5);
  }
}

TEST(RestWanted, SaysWhatCannotBe) {
  const CheckedMesh part = valley_block(kPi / 4.0);
  PlanOptions o = rest_options({}, 2.0, 0.3);
  o.rest_more_than = 0.1;
  const auto message = [&] {
    const auto planned = plan(part, o, {});
    return planned ? std::string("planned") : planned.error().message;
  };
  EXPECT_NE(message().find("there is no operation before"), std::string::npos) << message();
  o.earlier = {cut_before(part, rest_options({}, 2.0, 0.3))};
  o.rest_more_than = 0.9;
  EXPECT_NE(message().find("nowhere do the operations before leave more"), std::string::npos) << message();
  o.rest_more_than = 1.5;
  EXPECT_NE(message().find("smallest radius of the cutters"), std::string::npos) << message();
  o.rest_more_than = 0.1, o.axis.mode = AxisMode::kFree;
  EXPECT_NE(message().find("axis mode free"), std::string::npos) << message();
}

/// Moves of any kind of tool in an axis field, and what a search along each of them says.
TEST(ClearedSpace, IsWhereTheToolHasBeenAndAboveIt) {
  std::mt19937 random(7);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::size_t inside = 0, outside = 0;
  for (const AxisFrame& frame : frames_over_a_valley())
    for (const CutterType type : {CutterType::kBall, CutterType::kFlat, CutterType::kBullNose}) {
      EarlierCut cut{rest_options(frame, 6.0, 0.5), {}};
      cut.options.cutter.type = type,
      cut.options.cutter.corner_radius = type == CutterType::kBullNose ? 1.0 : 0.0;
      const Deformation map(frame, 1.0);
      Point<Part> from;
      for (int i = 0; i < 40; ++i) {
        const Point<Part> to{draw(-15, 15), draw(-15, 15), draw(0, 8)};
        for (int k = 1; k <= 15; ++k) {  // as a plan does, in moves in which the axis turns little
          const Point<Part> tip = lerp(from, to, k / 15.0);
          cut.moves.push_back({{tip, map.axis_at(tip)}, i % 5 == 0 ? MoveKind::kRapid : MoveKind::kCut});
        }
        from = to;
      }
      const ClearedSpace space(cut);
      const double r = 3.0, nose = type == CutterType::kBall       ? 3.0
                                   : type == CutterType::kBullNose ? 1.0
                                                                   : 0.0;
      const auto depth =
          [&](Point<Part> p) {  // of p in the tool, most of all places of the moves; below 0: out
            double most = -1e9;
            for (std::size_t i = 1; i < cut.moves.size(); ++i) {
              if (cut.moves[i].kind != MoveKind::kCut) continue;
              for (int k = 0; k <= 14; ++k) {
                const Pose &a = cut.moves[i - 1].pose, &b = cut.moves[i].pose;
                const Vec3 axis = normalized(lerp(Point<Part>{} + a.axis, Point<Part>{} + b.axis, k / 14.0) -
                                             Point<Part>{});
                const Vec3 w = p - lerp(a.tip, b.tip, k / 14.0);
                const double h = dot(w, axis), d = length(w - axis * h);
                if (h < 0.0) continue;
                const double wide = h >= nose ? r : r - nose + std::sqrt(h * (2.0 * nose - h));
                most = std::max(most, wide - d);
              }
            }
            return most;
          };
      for (int i = 0; i < 400; ++i) {
        const Point<Part> p{draw(-22, 22), draw(-22, 22), draw(-4, 20)};
        const double deep = depth(p);
        if (deep > 0.1) {
          EXPECT_TRUE(space.holds(p, 0.02)) << deep << " mode " << static_cast<int>(frame.mode);
          ++inside;
        } else if (deep < -0.3) {
          EXPECT_FALSE(space.holds(p, 0.02)) << deep << " mode " << static_cast<int>(frame.mode);
          ++outside;
        }
      }
    }
  EXPECT_GT(inside, 500u);
  EXPECT_GT(outside, 500u);
}

}  // namespace
}  // namespace tiltfeed
