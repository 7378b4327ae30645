// Fits through points of known shapes: exact, with noise, of short arcs, with outliers, nearly flat, far from
// zero.
#include "pathgen/fit/fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kinematics/basics/units.h"
#include "tests/shapes/box_mesh.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kTurn = 2.0 * kPi;

struct Case {
  const char* name;
  double noise = 0.0;      ///< standard deviation along the normal, mm
  double arc = 2.0 * kPi;  ///< rad, of each circle of the shape
  double outliers = 0.0;   ///< share
  double radius = 50.0;    ///< mm; of a torus: of its tube, the ring's being four times as large
  Vec3 away{};             ///< of the shape from zero, mm
};

constexpr Case kCases[] = {
    {"exact"},
    {"noise", 1e-3},
    {"arc of 40 degrees", 1e-3, kTurn / 9.0},
    {"arc of 10 degrees", 1e-3, kTurn / 36.0},
    {"outliers", 1e-3, kTurn, 0.3},
    {"outliers on 40 degrees", 1e-3, kTurn / 9.0, 0.3},
    {"radius of 1 km", 0.0, 1e-4, 0.0, 1e6},
    {"1 km from zero", 1e-3, kTurn, 0.0, 50.0, {1e6, -1e6, 1e6}},
    {"1 km from zero, exact", 0.0, kTurn, 0.0, 50.0, {1e6, -1e6, 1e6}},
};

/// A shape in a general position, and points of it.
struct Truth {
  FitKind kind;
  Point<Part> centre;
  Vec3 axis = normalized(Vec3{0.3, -0.5, 0.8}), u, v;
  double radius, tube;

  Truth(FitKind k, const Case& c) : kind(k), centre(Point<Part>{12, -7, 30} + c.away) {
    u = normalized(cross(axis, Vec3{1, 0, 0})), v = cross(axis, u);
    radius = k == FitKind::kTorus ? 4.0 * c.radius : k == FitKind::kPlane ? 0.0 : c.radius;
    tube = k == FitKind::kTorus ? c.radius : 0.0;
  }
  FitPoint at(double theta, double phi, double along) const {
    const Vec3 out = u * std::cos(theta) + v * std::sin(theta);
    switch (kind) {
      case FitKind::kPlane:
        return {centre + out * along, axis};
      case FitKind::kCircle:
        return {centre + out * radius, out};
      case FitKind::kSphere: {
        const Vec3 n = out * std::cos(phi) + axis * std::sin(phi);
        return {centre + n * radius, n};
      }
      case FitKind::kCylinder:
        return {centre + out * radius + axis * along, out};
      case FitKind::kTorus:
        break;
    }
    const Vec3 n = out * std::cos(phi) + axis * std::sin(phi);
    return {centre + out * radius + n * tube, n};
  }
};

std::vector<FitPoint> points_of(const Truth& truth, const Case& c, unsigned seed, std::size_t count = 400) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> even(-0.5, 0.5);
  std::normal_distribution<double> noise(0.0, 1.0);
  const double size = c.radius * std::min(1.0, c.arc);
  std::vector<FitPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    FitPoint p = truth.at(even(random) * c.arc, even(random) * c.arc, size * (0.01 + even(random)));
    p.place = p.place + p.normal * (c.noise * noise(random));
    if (truth.kind == FitKind::kCircle) p.place = p.place + truth.axis * (c.noise * noise(random));
    if (static_cast<double>(i) < c.outliers * static_cast<double>(count)) {
      const Vec3 off{even(random), even(random), even(random)};
      p.place = p.place + off * size;
      p.normal = normalized(p.normal + off);
    }
    points.push_back(p);
  }
  return points;
}

/// Of the fit from the truth.
struct Missed {
  double centre, axis, radius, tube;
};
Missed missed(const Fit& fit, const Truth& truth) {
  Vec3 off = fit.centre - truth.centre;
  const double axis = std::min(angle_between(fit.axis, truth.axis), angle_between(fit.axis, -truth.axis));
  if (truth.kind == FitKind::kPlane) off = truth.axis * dot(off, truth.axis);
  if (truth.kind == FitKind::kCylinder) off = off - truth.axis * dot(off, truth.axis);
  return {length(off), truth.kind == FitKind::kSphere ? 0.0 : axis, std::abs(fit.radius - truth.radius),
          std::abs(fit.tube - truth.tube)};
}

constexpr FitKind kKinds[] = {FitKind::kPlane, FitKind::kCircle, FitKind::kSphere, FitKind::kCylinder,
                              FitKind::kTorus};

TEST(Fit, FindsTheShapeWithinWhatItSaysOfItsOwnDoubt) {
  for (const FitKind kind : kKinds)
    for (Case c : kCases) {
      SCOPED_TRACE(std::string(word_of(kind)) + ", " + c.name);
      // A nearly flat torus is told from other surfaces only by how its curvatures change: a longer arc.
      if (kind == FitKind::kTorus && c.radius > 1e5) c.arc = 0.1;
      const Truth truth(kind, c);
      const auto found = fit(kind, points_of(truth, c, 7));
      ASSERT_TRUE(found) << found.error().message;
      const Missed off = missed(*found, truth);
      // Five deviations, and the rounding of coordinates: worse by (radius / size)^2 on a short arc.
      const double far = 1e-15 * (length(c.away) + c.radius) * 50.0,
                   bent = std::max(1.0, std::pow(3.0 / c.arc, 2));
      EXPECT_LE(off.centre, 5.0 * found->doubt.centre + far * bent);
      EXPECT_LE(off.axis, 5.0 * found->doubt.axis + far * bent / c.radius);
      EXPECT_LE(off.radius, 5.0 * found->doubt.radius + far * bent * 4.0);
      EXPECT_LE(off.tube, 5.0 * found->doubt.tube + far * bent);
      EXPECT_EQ(found->points + found->left_out, 400u);
      EXPECT_GE(found->rms, 0.0);
      if (c.outliers == 0.0) {
        EXPECT_LE(found->left_out, 2u);
        EXPECT_NEAR(found->rms, kind == FitKind::kCircle ? c.noise * std::sqrt(2.0) : c.noise,
                    0.1 * c.noise + far);
      } else {
        EXPECT_NEAR(static_cast<double>(found->left_out), 400.0 * c.outliers, 400.0 * 0.02);
      }
    }
}

TEST(Fit, SaysItsDoubtAsOtherNoiseScatters) {
  for (const FitKind kind : kKinds)
    for (const Case& c : {kCases[1], kCases[2], kCases[3]}) {
      SCOPED_TRACE(std::string(word_of(kind)) + ", " + c.name);
      const Truth truth(kind, c);
      constexpr int kSeeds = 20;
      double radius2 = 0.0, said2 = 0.0, axis2 = 0.0, axis_said2 = 0.0;
      for (unsigned seed = 1; seed <= kSeeds; ++seed) {
        const auto found = fit(kind, points_of(truth, c, seed, 150), {.leave_outliers = false});
        ASSERT_TRUE(found) << found.error().message;
        const Missed off = missed(*found, truth);
        radius2 += off.radius * off.radius, said2 += found->doubt.radius * found->doubt.radius;
        axis2 += off.axis * off.axis, axis_said2 += found->doubt.axis * found->doubt.axis;
      }
      if (kind != FitKind::kPlane) {
        EXPECT_LT(radius2, 3.0 * said2);
        EXPECT_GT(radius2, said2 / 4.0);
      }
      // The worst direction is said, both are missed.
      if (kind != FitKind::kSphere) {
        EXPECT_LT(axis2, 5.0 * axis_said2);
        EXPECT_GT(axis2, axis_said2 / 4.0);
      }
    }
}

TEST(Fit, IsTheLeastSumOfSquares) {
  for (const FitKind kind : kKinds) {
    SCOPED_TRACE(word_of(kind));
    const Case c{"noise", 0.2, kTurn / 4.0};
    const Truth truth(kind, c);
    const auto points = points_of(truth, c, 3);
    const auto found = fit(kind, points, {.leave_outliers = false});
    ASSERT_TRUE(found) << found.error().message;
    const auto sum = [&](const Fit& shape) {
      double squares = 0.0;
      for (const FitPoint& p : points) squares += std::pow(distance_to(shape, p.place), 2);
      return squares;
    };
    const double least = sum(*found);
    EXPECT_NEAR(std::sqrt(least / 400.0), found->rms, 1e-9);
    for (const double step : {1e-3, -1e-3}) {
      for (const Vec3 way : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        Fit moved = *found, turned = *found;
        moved.centre = moved.centre + way * step, turned.axis = normalized(turned.axis + way * step);
        EXPECT_GE(sum(moved), least * (1.0 - 1e-12));
        EXPECT_GE(sum(turned), least * (1.0 - 1e-12));
      }
      Fit wider = *found, thicker = *found;
      wider.radius += step, thicker.tube += step;
      EXPECT_GE(sum(wider), least * (1.0 - 1e-12));
      EXPECT_GE(sum(thicker), least * (1.0 - 1e-12));
    }
  }
}

TEST(Fit, OfAMovedShapeIsMoved) {
  const Case here{"here", 1e-3, 1.0}, there{"there", 1e-3, 1.0, 0.0, 50.0, {1000, 2000, -3000}};
  for (const FitKind kind : kKinds) {
    SCOPED_TRACE(word_of(kind));
    const auto a = fit(kind, points_of(Truth(kind, here), here, 5)),
               b = fit(kind, points_of(Truth(kind, there), there, 5));
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(length(b->centre - a->centre - there.away), 0.0, 1e-6);
    EXPECT_NEAR(a->radius, b->radius, 1e-6);
    EXPECT_NEAR(a->doubt.centre, b->doubt.centre, 1e-6 + 1e-3 * a->doubt.centre);
  }
}

TEST(Fit, RefusesWhatPointsDoNotSay) {
  const Case c{"exact"};
  for (const FitKind kind : kKinds) {
    SCOPED_TRACE(word_of(kind));
    EXPECT_FALSE(fit(kind, {}));
    const std::vector<FitPoint> one(20, FitPoint{{1, 2, 3}, {0, 0, 1}});
    EXPECT_FALSE(fit(kind, one)) << "one place";
    std::vector<FitPoint> line;
    for (int i = 0; i < 20; ++i) line.push_back({{1.0 * i, 2.0, 3.0}, {0, 0, 1}});
    EXPECT_FALSE(fit(kind, line)) << "a straight line";
    if (kind == FitKind::kPlane || kind == FitKind::kCircle) continue;
    const auto flat = fit(kind, points_of(Truth(FitKind::kPlane, c), c, 1));
    ASSERT_FALSE(flat) << "a plane, radius " << flat->radius;
    EXPECT_NE(flat.error().message.find(word_of(kind)), std::string::npos);
  }
}

TEST(Fit, TakesCornersForTheAreaThatIsTheirs) {
  const Mesh box = box_mesh({{Vec3{0, 0, 0}, Vec3{4, 2, 1}}});
  std::vector<std::uint32_t> all(box.facets.size());
  for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
  double area = 0.0;
  const auto points = corners_of(box, all);
  for (const FitPoint& p : points) area += p.weight;
  EXPECT_EQ(points.size(), 8u);
  EXPECT_NEAR(area, 28.0, 1e-12);
}

}  // namespace
}  // namespace tiltfeed
