// What passes promise: their distance on the part, the ridges they leave and containment, each by brute force
// on the planned path.
#include "pathgen/pattern/passes.h"

#include <gtest/gtest.h>

#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

const AxisFrame kLineFrame{AxisMode::kLine, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};

/// What the side step may be exceeded by: rows are spaced by what the surface is at their own points.
constexpr double kStepSlack = 1.05;
/// Least share of the side step that neighbours are apart as a rule: halving, less what rows bend.
constexpr double kStepShare = 0.4;

struct Spacing {
  double widest = 0.0;   ///< twice the largest distance of a place from the nearest pass
  double typical = 0.0;  ///< median distance of a pass from another
};

/// Of the tips at `places` (where the tool touches the surface there).
Spacing spacing(const std::vector<CutRun>& runs, const std::vector<Point<Part>>& places) {
  Spacing found;
  std::vector<double> apart;
  const auto fine = dense(runs, 1.0);
  for (Point<Part> p : places) {
    found.widest = std::max(found.widest, 2.0 * from_runs(p, runs));
    double nearest = std::numeric_limits<double>::infinity();
    const CutRun* own = nullptr;
    Point<Part> on;
    for (std::size_t r = 0; r < fine.size(); ++r)
      for (const Pose& pose : fine[r])
        if (const double d = distance(pose.tip, p); d < nearest) nearest = d, own = &runs[r], on = pose.tip;
    apart.push_back(from_runs(on, runs, own));
  }
  found.typical = median(apart);
  return found;
}

/// Places of a grid, `map` giving the tip for each.
std::vector<Point<Part>> places(const Grid& g, const std::function<Point<Part>(double, double)>& tip) {
  std::vector<Point<Part>> found;
  for (int i = 0; i <= g.columns; ++i)
    for (int j = 0; j <= g.rows; ++j)
      found.push_back(tip(g.u0 + (g.u1 - g.u0) * i / g.columns, g.v0 + (g.v1 - g.v0) * j / g.rows));
  return found;
}

void expect_side_step(const CheckedMesh& part, PlanOptions o, const std::vector<Point<Part>>& where) {
  o.pattern.measure = StepMeasure::kSurface;
  const Spacing surface = spacing(runs_of(part, o), where);
  EXPECT_LE(surface.widest, kStepSlack * o.pattern.side_step);
  EXPECT_GE(surface.typical, kStepShare * o.pattern.side_step);
  o.pattern.measure = StepMeasure::kFlat;
  EXPECT_GT(spacing(runs_of(part, o), where).widest, 1.2 * o.pattern.side_step);
}

TEST(Passes, KeepTheSideStepOnASteepPlane) {
  const double slope = std::tan(kPi / 3.0), r = 2.0;
  const CheckedMesh part =
      sheet(kUpright, {-12, 12, -10, 10, 1, 1}, [&](double, double v) { return slope * v; });
  const Vec3 lift = (normalized(Vec3{0, -slope, 1}) - Vec3{0, 0, 1}) * r;  // from the contact to the tip
  const auto where = places({-9.1, 9.3, -7.2, 7.1, 31, 61}, [&](double u, double v) {
    return Point<Part>{u, v, slope * v} + lift;
  });
  for (double angle : {0.0, 30.0}) {
    PlanOptions o = options_with(kUpright);
    o.pattern.angle = Angle::from_degrees(angle);
    expect_side_step(part, o, where);
  }
}

TEST(Passes, KeepTheSideStepFarFromTheMeanRadius) {
  const auto rho = [](double u, double) { return u < 40.0 ? 12.0 : 30.0; };
  const CheckedMesh part = sheet(kLineFrame, {0, 56, -0.8, 0.8, 56, 80}, rho);
  const auto where = places({45.0, 52.0, -0.7, 0.7, 7, 91}, [](double u, double v) {
    return Point<Part>{u, -30.0 * std::sin(v), 30.0 * std::cos(v)};
  });
  const Deformation map(kLineFrame, 1.0);
  for (Point<Part> p : where) ASSERT_NEAR(map.flatten(p).z, 30.0, 1e-9);
  PlanOptions o = options_with(kLineFrame);
  expect_side_step(part, o, where);
}

TEST(Passes, KeepTheSideStepNearThePole) {
  const auto rho = [](double, double v) { return v < 0.9 ? 10.0 : 32.0; };
  const CheckedMesh part = sheet(kPointFrame, {-1.5, 1.5, 0.2, 1.35, 60, 46}, rho);
  const Deformation map(kPointFrame, 1.0);
  const auto where = places({-1.3, 1.3, 1.0, 1.25, 23, 11}, [&](double u, double v) {
    return map.unflatten({u, v, 32.0});
  });
  PlanOptions o = options_with(kPointFrame);
  o.pattern.side_step = 1.0;
  expect_side_step(part, o, where);             // rows round the pole: far from the mean radius
  o.pattern.angle = Angle::from_degrees(45.0);  // rows that meet at the pole at a slant
  o.pattern.measure = StepMeasure::kSurface;
  const Spacing slanted = spacing(runs_of(part, o), where);
  EXPECT_LE(slanted.widest, kStepSlack * o.pattern.side_step);
  EXPECT_GE(slanted.typical, kStepShare * o.pattern.side_step);
}

/// Height that balls of radius r along the runs leave over p, along n.
double left_over(Point<Part> p, Vec3 n, const std::vector<CutRun>& fine, double r) {
  double height = std::numeric_limits<double>::infinity();
  for (const CutRun& run : fine)
    for (const Pose& pose : run) {
      const Vec3 w = pose.tip + pose.axis * r - p;
      const double up = dot(w, n), aside = squared_length(w) - up * up;
      if (aside < r * r) height = std::min(height, up - std::sqrt(r * r - aside));
    }
  return height;
}

/// The ridges' heights along a row of places across the passes.
std::vector<double> ridges(const std::vector<double>& heights) {
  std::vector<double> tops;
  for (std::size_t i = 1; i + 1 < heights.size(); ++i)
    if (heights[i] >= heights[i - 1] && heights[i] > heights[i + 1]) tops.push_back(heights[i]);
  return tops;
}

void expect_ridges(double slope, double scallop) {
  const double rise = std::tan(slope);
  const CheckedMesh part = sheet(kUpright, {-8, 8, -8, 8, 1, 1}, [&](double, double v) { return rise * v; });
  PlanOptions o = options_with(kUpright);
  o.pattern.side_step = 0.0;
  o.pattern.measure = StepMeasure::kScallop;
  o.pattern.scallop = scallop;
  const auto fine = dense(runs_of(part, o), 0.05);
  std::vector<double> tops;
  for (double u : {-5.0, 0.3, 4.1}) {
    std::vector<double> heights;
    for (double v = -4.0; v < 4.0; v += 0.03)
      heights.push_back(left_over({u, v, rise * v}, normalized(Vec3{0, -rise, 1}), fine, o.cutter.radius()));
    for (double top : ridges(heights)) tops.push_back(top);
  }
  ASSERT_GT(tops.size(), 15u);
  EXPECT_LE(*std::max_element(tops.begin(), tops.end()), kStepSlack * scallop);
  EXPECT_GE(median(tops), scallop / 4.0);
}

TEST(Passes, LeaveRidgesAsHighAsTheScallop) {
  for (double scallop : {0.02, 0.1}) {
    expect_ridges(kPi / 4.0, scallop);
    expect_ridges(kPi / 3.0, scallop);  // where rows, twice halved, are just near enough
  }
}

// The step is taken at the ball's centre, which a bore brings nearer together than the surface.
TEST(Passes, LeaveRidgesNoHigherThanTheScallopInABore) {
  AxisFrame frame = kLineFrame;
  frame.sense = Sense::kInward;
  const double radius = 10.0;
  const CheckedMesh part = sheet(frame, {0, 12, -1.2, 1.2, 4, 160}, [&](double, double) { return -radius; });
  PlanOptions o = options_with(frame);
  o.cutter = {8.0, 100.0, 8.0};
  o.links.clearance = 1.0;
  o.pattern.side_step = 0.0;
  o.pattern.measure = StepMeasure::kScallop;
  o.pattern.scallop = 0.1;
  const Deformation map(frame, 1.0);
  const auto fine = dense(runs_of(part, o), 0.05);
  for (double v = -0.8; v < 0.8; v += 0.005) {
    const Point<Part> p = map.unflatten({6.0, v, -radius});
    EXPECT_LE(left_over(p, map.axis_at(p), fine, o.cutter.radius()), kStepSlack * o.pattern.scallop);
  }
}

/// Least and largest of the tips' own coordinates (mm or rad) and of the cutter locations' heights.
struct Extent {
  double low[3], high[3];
};

/// `reference`: of the cutter location over the tip, mm.
Point<Flat> own_coordinates(const Pose& pose, const Deformation& map, double reference) {
  const Point<Flat> f = map.flatten(pose.tip + pose.axis * reference);
  return {f.x / map.scale_x(), f.y / map.scale_y(), f.z};
}

Extent extent(const std::vector<CutRun>& runs, const AxisFrame& axis, double reference) {
  const Deformation map(axis, 1.0);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Extent e{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const CutRun& run : runs)
    for (const Pose& pose : run) {
      const Point<Flat> f = own_coordinates(pose, map, reference);
      const double at[3] = {f.x, f.y, f.z};
      for (int i = 0; i < 3; ++i)
        e.low[i] = std::min(e.low[i], at[i]), e.high[i] = std::max(e.high[i], at[i]);
    }
  return e;
}

constexpr double kBorder = 1e-6;  ///< rounding of a limit, mm or rad

/// Along the rows cuts end at the limits; across them the outermost row is at most half a step inside.
void expect_limits(const AxisFrame& axis, Interval first, Interval second, Along along) {
  PlanOptions o = options_with(axis);
  o.pattern.along = along;
  o.containment.first = first, o.containment.second = second;
  const Extent e = extent(runs_of(slab(axis), o), axis, o.cutter.radius());
  // A ring's scales: the slab's ground is kGroundRadius from the circle, and nothing of it much further in.
  const bool ring = axis.mode == AxisMode::kCircle;
  const double half = 1.1 * o.pattern.side_step / 2.0;
  const double across[2] = {ring ? half / (kGroundRadius + axis.circle_radius) : half,
                            ring ? half / kGroundRadius : half};
  const Interval limits[2] = {first, second};
  for (int i = 0; i < 2; ++i) {
    const double inside = (i == 0) == (along == Along::kX) ? kBorder : across[i];
    EXPECT_GE(e.low[i], limits[i].low - kBorder);
    EXPECT_LE(e.high[i], limits[i].high + kBorder);
    EXPECT_LE(e.low[i], limits[i].low + inside);
    EXPECT_GE(e.high[i], limits[i].high - inside);
  }
}

TEST(Passes, StayWithinLimitsOfTheirCoordinatesAndReachThem) {
  for (Along along : {Along::kX, Along::kY}) {
    expect_limits(kUpright, {-7.3, 5.1}, {-3.7, 6.2}, along);
    expect_limits(kRing, {-0.06, 0.07}, {-0.1, 0.15}, along);
  }
}

TEST(Passes, StayWithinLimitsOfTheHeight) {
  for (const AxisFrame& axis : {kUpright, kRing}) {
    PlanOptions o = options_with(axis);
    o.max_point_distance = 0.2;
    const double ground = axis.mode == AxisMode::kFixed ? 0.0 : kGroundRadius;
    o.containment.height = {ground + 2.9, ground + 4.6};  // of the ball's centre
    const auto runs = runs_of(slab(axis), o);
    ASSERT_GT(runs.size(), 10u);
    const Extent e = extent(runs, axis, o.cutter.radius());
    EXPECT_GE(e.low[2], ground + 2.9 - o.max_point_distance);
    EXPECT_LE(e.high[2], ground + 4.6 + o.max_point_distance);
    EXPECT_LE(e.low[2], ground + 2.9 + o.max_point_distance);
    EXPECT_GE(e.high[2], ground + 4.6 - o.max_point_distance);
  }
}

const std::vector<std::array<double, 2>> kEll{{-8, -7}, {7, -7}, {7, 0}, {1, 0}, {1, 6}, {-8, 6}};
/// Is (x, y) in the L, moved outwards by `grown`?
bool in_ell(double x, double y, double grown) {
  return x > -8 - grown && y > -7 - grown &&
         ((x < 7 + grown && y < grown) || (x < 1 + grown && y < 6 + grown));
}

TEST(Passes, StayInABoundaryAndCoverIt) {
  const CheckedMesh part = sheet(kUpright, {-15, 15, -15, 15, 1, 1}, [](double, double) { return 0.0; });
  for (double angle : {0.0, 25.0, 90.0}) {
    PlanOptions o = options_with(kUpright);
    o.containment.boundary = kEll;
    o.pattern.angle = Angle::from_degrees(angle);
    const auto runs = runs_of(part, o);
    for (const CutRun& run : dense(runs, 0.2))
      for (const Pose& pose : run) EXPECT_TRUE(in_ell(pose.tip.x, pose.tip.y, kBorder));
    for (double x = -8.0; x <= 7.0; x += 0.5)
      for (double y = -7.0; y <= 6.0; y += 0.5)
        if (in_ell(x, y, 0.0)) {
          // At a slant a row may end up to a whole step before the corner beside it.
          EXPECT_LE(from_runs(Point<Part>{x, y, 0.0}, runs),
                    (angle == 25.0 ? 1.0 : 0.5) * o.pattern.side_step + kBorder)
              << x << " " << y;
        }
  }
}

TEST(Passes, SayWhenTheContainmentIsEmpty) {
  const CheckedMesh part = sheet(kUpright, {-5, 5, -5, 5, 1, 1}, [](double, double) { return 0.0; });
  std::vector<Containment> empty(5);
  empty[0].first = {20, 30};
  empty[1].second = {-30, -20};
  empty[2].height = {9, 12};
  empty[3].boundary = {{20, 20}, {30, 20}, {20, 30}};
  empty[4].first = {2, -2};
  for (const Containment& containment : empty) {
    PlanOptions o = options_with(kUpright);
    o.containment = containment;
    const auto planned = plan(part, o, nullptr);
    ASSERT_FALSE(planned);
    EXPECT_EQ(planned.error().code, Code::kUnreachable);
    EXPECT_NE(planned.error().message.find("containment"), std::string::npos) << planned.error().message;
  }
}

}  // namespace
}  // namespace tiltfeed
