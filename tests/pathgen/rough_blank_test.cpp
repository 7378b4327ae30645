// Roughing from a blank that the job states, by dots of stock that the moves cut in their order.

#include "pathgen/plan/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/tool/blank_solid.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kRadius = 4.0, kShank = 60.0, kLayer = 2.0, kAllowance = 0.3;

PlanOptions roughing(AxisMode mode) {
  PlanOptions o;
  o.axis.mode = mode;
  o.cutter.type = CutterType::kBall, o.cutter.diameter = 2.0 * kRadius;
  o.cutter.cutting_length = o.cutter.shank_length = kShank, o.cutter.length = 80.0;
  o.pattern.kind = PatternKind::kRough;
  o.pattern.side_step = 2.0, o.pattern.step_down = kLayer;
  o.tolerance = 0.02, o.allowance = kAllowance;
  o.links.clearance = 4.0, o.links.approach = 1.0;
  o.cut_feed = Feed::from_mm_per_min(2000.0), o.plunge_feed = Feed::from_mm_per_min(400.0);
  return o;
}

double distance_to(const Box& box, Point<Part> p) {
  return distance(p, {std::clamp(p.x, box.min.x, box.max.x), std::clamp(p.y, box.min.y, box.max.y),
                      std::clamp(p.z, box.min.z, box.max.z)});
}

struct RoughRun {
  double rapid = 0.0;     ///< deepest of a dot in a rapid, mm
  double highest = -1e9;  ///< of the tip on a cut, z or from the line
  std::size_t in_air = 0, cuts = 0;
  std::vector<Point<Part>> left;
};

/// Dots at random in the blank; those that a cut comes over are gone.
RoughRun run(const std::vector<Move>& moves, const BlankSolid& blank, const Box& part, bool line) {
  std::mt19937 random(11);
  const Box& b = blank.bounds();
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  RoughRun all;
  while (all.left.size() < 1500) {
    const Point<Part> p{draw(b.min.x, b.max.x), draw(b.min.y, b.max.y), draw(b.min.z, b.max.z)};
    if (blank.holds(p, 0.0) && distance_to(part, p) > 0.0) all.left.push_back(p);
  }
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Pose &from = moves[i - 1].pose, &to = moves[i].pose;
    const double steps = std::max(1.0, std::ceil(distance(from.tip, to.tip)));
    const bool rapid = moves[i].kind == MoveKind::kRapid, cut = moves[i].kind == MoveKind::kCut;
    bool any = false;
    for (double k = 1.0; k <= steps; ++k) {
      const Vec3 axis = slerp(from.axis, to.axis, k / steps);
      const Point<Part> tip = lerp(from.tip, to.tip, k / steps), centre = tip + axis * kRadius;
      const auto depth = [&](Point<Part> p) {
        return kRadius - distance_to_segment(p, centre, centre + axis * kShank);
      };
      if (cut) all.highest = std::max(all.highest, line ? std::hypot(tip.y, tip.z) : tip.z);
      if (rapid) {
        for (const Point<Part>& p : all.left) all.rapid = std::max(all.rapid, depth(p));
        continue;
      }
      any |= std::erase_if(all.left, [&](Point<Part> p) { return depth(p) >= 0.0; }) > 0;
    }
    if (cut) ++all.cuts, all.in_air += any ? 0 : 1;
  }
  return all;
}

struct Case {
  const char* name;
  AxisMode mode;
  Box part;
  BlankSolid blank;
};

std::vector<Case> cases() {
  const Box block{{-10, -8, 0}, {10, 8, 12}}, bar{{-15, -5, -5}, {15, 5, 5}};
  return {{"box", AxisMode::kFixed, block, BlankSolid::box({{-16, -14, -4}, {16, 14, 19}})},
          {"cylinder", AxisMode::kFixed, block, BlankSolid::bar({0, 0, -2}, {0, 0, 1}, 18.0, 18.0)},
          {"file", AxisMode::kFixed, block,
           BlankSolid::closed(BlankSolid::box({{-13, -12, -4}, {18, 11, 16}}).mesh())},
          {"about a line", AxisMode::kLine, bar, BlankSolid::bar({-18, 0, 0}, {1, 0, 0}, 12.0, 36.0)}};
}

TEST(RoughBlank, AllThatLiesInReachIsCutAndNoRapidMeetsStock) {
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    const bool line = one.mode == AxisMode::kLine;
    CheckedMesh part;
    part.mesh = BlankSolid::box(one.part).mesh(), part.bounds = one.part;
    PlanOptions o = roughing(one.mode);
    o.blank = std::make_shared<const BlankSolid>(one.blank), o.from_blank = true;
    const Result<Plan> planned = plan(part, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    const RoughRun found = run(planned->path.moves, one.blank, one.part, line);
    EXPECT_LT(found.rapid, 0.05);
    // No layer is over the blank.
    const double top = line ? 12.0 : one.blank.bounds().max.z;
    EXPECT_LT(found.highest, top);
    EXPECT_GT(found.highest, top - kLayer - 0.1);
    // A layer leaves a step down over the part, rows a ridge, most of it beside the wall. Under the part's
    // lowest place no layer goes.
    for (const Point<Part>& p : found.left) {
      const bool under = line ? std::hypot(p.y, p.z) < 7.5 : p.z < 2.5;
      if (!under) {
        EXPECT_LT(distance_to(one.part, p), kAllowance + kLayer + 0.4) << p.x << ' ' << p.y << ' ' << p.z;
      }
    }
  }
}

/// Behind those moves, with the blank stated and without it.
void comes_down_to_stock(const CheckedMesh& part, PlanOptions o, const Case& of,
                         const std::vector<Move>& before = {}) {
  for (const bool stated : {true, false}) {
    if (!stated) o.blank = nullptr, o.from_blank = false;
    const Result<Plan> planned = plan(part, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    std::vector<Move> moves = before;
    moves.insert(moves.end(), planned->path.moves.begin(), planned->path.moves.end());
    const double deep = run(moves, of.blank, of.part, false).rapid;
    if (stated) {
      EXPECT_LT(deep, 0.05);
    } else {
      EXPECT_GT(deep, 1.0) << "nothing to come down into";
    }
  }
}

TEST(RoughBlank, TheFirstOperationComesDownToItWhateverItsPattern) {
  const Case one = cases().front();
  CheckedMesh part;
  part.mesh = BlankSolid::box(one.part).mesh(), part.bounds = one.part;
  PlanOptions o = roughing(one.mode);
  o.pattern = {}, o.pattern.side_step = 1.0;
  o.blank = std::make_shared<const BlankSolid>(one.blank), o.from_blank = true;
  comes_down_to_stock(part, o, one);
}

TEST(RoughBlank, ItComesDownToAllOfItWhereAContainmentBeginsLower) {
  const Case one = cases().front();
  CheckedMesh part;
  part.mesh = BlankSolid::box(one.part).mesh(), part.bounds = one.part;
  PlanOptions o = roughing(one.mode);
  o.containment.height = {-4.0, 14.0};
  o.blank = std::make_shared<const BlankSolid>(one.blank), o.from_blank = true;
  comes_down_to_stock(part, o, one);
}

Result<CheckedMesh> checked_part(const Case& of) {
  Stl stl;
  const Mesh block = BlankSolid::box(of.part).mesh();
  for (const auto& f : block.facets)
    stl.facets.push_back({block.vertices[f[0]], block.vertices[f[1]], block.vertices[f[2]]});
  return check_mesh(stl);
}

PlanOptions wide_rows(AxisMode mode, const Case& of) {
  PlanOptions o = roughing(mode);
  o.pattern = {}, o.pattern.side_step = 3.0;
  o.free.plane_normals = {{1, 0, 0}, {0, 0, 1}};
  o.free.max_turn = Angle::from_degrees(5), o.free.smoothing = kRadius;
  o.indexed.most_directions = 3;
  o.blank = std::make_shared<const BlankSolid>(of.blank);
  return o;
}

TEST(RoughBlank, AFreeAxisAndFixedDirectionsComeDownToItToo) {
  const Case one = cases().front();
  const auto part = checked_part(one);
  ASSERT_TRUE(part);
  for (const AxisMode mode : {AxisMode::kFree, AxisMode::kIndexed}) {
    SCOPED_TRACE(static_cast<int>(mode));
    PlanOptions o = wide_rows(mode, one);
    o.from_blank = true;
    comes_down_to_stock(*part, o, one);
  }
}

TEST(RoughBlank, TheyComeDownToWhatARoughLeavesOfIt) {
  const Case one = cases().front();
  const auto part = checked_part(one);
  ASSERT_TRUE(part);
  PlanOptions rough = roughing(AxisMode::kFixed);
  rough.blank = std::make_shared<const BlankSolid>(one.blank), rough.from_blank = true;
  rough.allowance = 4.0;
  const Result<Plan> roughed = plan(*part, rough, {});
  ASSERT_TRUE(roughed) << roughed.error().message;
  for (const AxisMode mode : {AxisMode::kFree, AxisMode::kIndexed}) {
    SCOPED_TRACE(static_cast<int>(mode));
    PlanOptions o = wide_rows(mode, one);
    o.earlier = {std::make_shared<const EarlierCut>(EarlierCut{rough, roughed->path.moves})};
    o.pattern.side_step = 6.0;
    comes_down_to_stock(*part, o, one, roughed->path.moves);
    // Not to all of the blank.
    PlanOptions whole = o;
    whole.earlier.clear(), whole.from_blank = true;
    const auto plunged = [&](const PlanOptions& options) {
      const Result<Plan> planned = plan(*part, options, {});
      double all = 0.0;
      for (std::size_t i = 1; i < planned->path.moves.size(); ++i)
        if (planned->path.moves[i].kind == MoveKind::kPlunge)
          all += distance(planned->path.moves[i - 1].pose.tip, planned->path.moves[i].pose.tip);
      return all;
    };
    EXPECT_LT(plunged(o), 0.9 * plunged(whole));
  }
}

double plunged(const std::vector<Move>& moves) {
  double all = 0.0;
  for (std::size_t i = 1; i < moves.size(); ++i)
    if (moves[i].kind == MoveKind::kPlunge) all += distance(moves[i - 1].pose.tip, moves[i].pose.tip);
  return all;
}

/// One behind the other, by way of places far above both.
std::vector<Move> both(const std::vector<Move>& first, const std::vector<Move>& then) {
  std::vector<Move> all = first;
  for (Pose pose : {first.back().pose, then.front().pose})
    pose.tip = pose.tip + pose.axis * 100.0, all.push_back({pose, MoveKind::kRapid});
  all.insert(all.end(), then.begin(), then.end());
  return all;
}

/// What operations with a free axis or in fixed directions have cleared, those behind them know.
TEST(RoughBlank, WhatAnyAxisHasClearedIsClear) {
  const Case one = cases().front();
  const auto part = checked_part(one);
  ASSERT_TRUE(part);
  for (const AxisMode mode : {AxisMode::kFree, AxisMode::kIndexed}) {
    SCOPED_TRACE(static_cast<int>(mode));
    PlanOptions first = wide_rows(mode, one);
    first.from_blank = true;
    const Result<Plan> before = plan(*part, first, {});
    ASSERT_TRUE(before) << before.error().message;
    const auto cut = std::make_shared<const EarlierCut>(EarlierCut{first, before->path.moves});
    // Rows come down to what it left, and not through it.
    for (const AxisMode behind : {AxisMode::kFixed, AxisMode::kIndexed}) {
      PlanOptions rows = wide_rows(behind, one), blind = rows;
      rows.earlier = {cut}, blind.from_blank = true;
      const Result<Plan> planned = plan(*part, rows, {}), unknowing = plan(*part, blind, {});
      ASSERT_TRUE(planned && unknowing);
      EXPECT_LT(run(both(before->path.moves, planned->path.moves), one.blank, one.part, false).rapid, 0.05);
      EXPECT_LT(plunged(planned->path.moves), 0.7 * plunged(unknowing->path.moves));
    }
    // A rough that asks for rest cuts what is left alone, and all of that.
    PlanOptions rough = roughing(AxisMode::kFixed);
    rough.blank = std::make_shared<const BlankSolid>(one.blank), rough.earlier = {cut};
    rough.rest_more_than = 0.5;
    PlanOptions whole = rough;
    whole.rest_more_than = 0.0, whole.earlier.clear(), whole.from_blank = true;
    const Result<Plan> rest = plan(*part, rough, {}), all = plan(*part, whole, {});
    ASSERT_TRUE(rest && all);
    EXPECT_LT(rest->report.cut_length, 0.8 * all->report.cut_length);
    const RoughRun found = run(both(before->path.moves, rest->path.moves), one.blank, one.part, false);
    EXPECT_LT(found.rapid, 0.05);
    for (const Point<Part>& p : found.left) {
      if (p.z < 2.5) continue;
      EXPECT_LT(distance_to(one.part, p), kAllowance + kLayer + 0.4) << p.x << ' ' << p.y << ' ' << p.z;
    }
  }
}

/// About a point the blank is seen beyond the poles; rows end there. A floor lies across one, a wall beside
/// it.
TEST(RoughBlank, NoRowRunsOnOverAPole) {
  const Box block{{-10, -8, -9}, {10, 8, 9}}, wall{{-10, 8, -9}, {-1, 14, 9}};
  CheckedMesh part;
  part.mesh = joined(BlankSolid::box(block).mesh(), BlankSolid::box(wall).mesh());
  part.bounds = {block.min, {10, 14, 9}};
  const struct {
    Along along;
    Point<Part> origin;
    double radius;
  } kCases[] = {{Along::kX, {5, 0, -4}, 4.0}, {Along::kY, {-5, 0, 3}, 2.0}};
  for (const auto& [along, origin, radius] : kCases) {
    PlanOptions o = roughing(AxisMode::kPoint);
    o.axis.origin = origin, o.axis.t = {1, 0, 0}, o.axis.n = {0, 0, 1};
    o.cutter.diameter = 2.0 * radius, o.pattern.along = along;
    o.blank = std::make_shared<const BlankSolid>(BlankSolid::box({{-14, -12, -13}, {14, 16, 13}}));
    o.from_blank = true;
    const Result<Plan> planned = plan(part, o, {});
    ASSERT_TRUE(planned) << planned.error().message;
    double nearest = 1e9;
    const std::vector<Move>& moves = planned->path.moves;
    for (std::size_t i = 1; i < moves.size(); ++i) {
      if (moves[i].kind != MoveKind::kCut) continue;
      const Pose &from = moves[i - 1].pose, &to = moves[i].pose;
      for (int k = 0; k <= 8; ++k) {
        const Point<Part> centre =
            lerp(from.tip, to.tip, k / 8.0) + slerp(from.axis, to.axis, k / 8.0) * radius;
        for (const Box& box : {block, wall}) nearest = std::min(nearest, distance_to(box, centre) - radius);
      }
    }
    EXPECT_GT(nearest, kAllowance - o.tolerance);
  }
}

TEST(BlankSolid, HoldsWhatIsInIt) {
  std::mt19937 random(3);
  const auto draw = [&](double reach) {
    return std::uniform_real_distribution<double>(-reach, reach)(random);
  };
  const Vec3 axis = normalized(Vec3{1, 2, -1});
  const Point<Part> base{1, -2, 3};
  const BlankSolid bar = BlankSolid::bar(base, axis, 6.0, 15.0),
                   box = BlankSolid::box({{-4, -3, -2}, {5, 6, 7}});
  const BlankSolid bar_mesh = BlankSolid::closed(bar.mesh()), box_mesh = BlankSolid::closed(box.mesh());
  std::size_t inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const Point<Part> p{draw(20), draw(20), draw(20)};
    const double h = dot(p - base, axis), d = length(p - base - axis * h);
    const double off_bar = std::max({-h, h - 15.0, d - 6.0}),
                 off_box = distance_to({{-4, -3, -2}, {5, 6, 7}}, p);
    if (std::abs(off_bar) > 2.0 * BlankSolid::kStandOut) {
      EXPECT_EQ(bar.holds(p, 0.0), off_bar < 0.0);
      EXPECT_EQ(bar_mesh.holds(p, 0.0), off_bar < 0.0);
    }
    EXPECT_EQ(box.holds(p, 0.0), off_box == 0.0);
    inside += off_bar < 0.0;
  }
  EXPECT_GT(inside, 50u);
}

/// In inside work the tool comes from a hollow, which a box need not have.
TEST(RoughBlank, InsideWorkThatBeginsInTheBlankIsRefused) {
  const AxisFrame frame{AxisMode::kLine, Sense::kInward, {}, {1, 0, 0}, {0, 0, 1}, 0.0};
  const CheckedMesh part = sheet(frame, {-20, 20, -0.35, 0.35, 8, 16}, [](double, double) { return -40.0; });
  PlanOptions o = options_with(frame);
  o.from_blank = true;
  for (const double margin : {0.0, 10.0}) {
    Box box = part.bounds;
    box.min = box.min - Vec3{margin, margin, margin}, box.max = box.max + Vec3{margin, margin, margin};
    o.blank = std::make_shared<const BlankSolid>(BlankSolid::box(box));
    const auto made = plan(part, o, nullptr);
    EXPECT_EQ(made.has_value(), margin == 0.0);
    if (made) continue;
    EXPECT_EQ(made.error().code, Code::kInput);
    EXPECT_NE(made.error().message.find("inside work begins in the blank"), std::string::npos)
        << made.error().message;
  }
}

/// On the inner half of a circle the tool reaches past the middle: not into a blank that lies there, too.
TEST(RoughBlank, NoWayPastTheMiddleOfACircleLeadsThroughIt) {
  CheckedMesh part;
  part.bounds = {{-4, -4, 3}, {4, 4, 6}}, part.mesh = BlankSolid::box(part.bounds).mesh();
  PlanOptions o = options_with({AxisMode::kCircle, Sense::kOutward, {}, {1, 0, 0}, {0, 0, 1}, 10.0});
  o.from_blank = true;
  const Box beyond{{-4.5, -4.5, -12}, {4.5, 4.5, 0}};
  for (const bool is_long : {false, true}) {
    const double low = is_long ? beyond.min.z : 2.5;
    o.blank = std::make_shared<const BlankSolid>(BlankSolid::box({{-4.5, -4.5, low}, {4.5, 4.5, 6.5}}));
    const auto made = plan(part, o, nullptr);
    ASSERT_TRUE(made) << made.error().message;
    std::size_t in_it = 0;
    for (const Move& move : made->path.moves)
      for (double h = 0.0; h < o.cutter.shank_length; h += 0.5)
        in_it += distance_to(beyond, move.pose.tip + move.pose.axis * h) == 0.0 ? 1 : 0;
    EXPECT_EQ(in_it == 0, is_long) << in_it;
    EXPECT_GT(made->report.passes, 0u);
  }
}

}  // namespace
}  // namespace tiltfeed
