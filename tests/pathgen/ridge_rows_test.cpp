// Rows as far apart as their ridges allow, on the whole plan: what is left on the part is measured by brute
// force on the path, beside what evenly spaced rows leave.
#include "pathgen/pattern/ridge_rows.h"

#include <gtest/gtest.h>

#include "sim/solid/distance.h"
#include "tests/judges/ball_track.h"
#include "tests/judges/surface_sample.h"
#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// What a path leaves of one place, mm.
struct Left {
  double even = 0.0, ridge = 0.0;
};

struct Compared {
  std::vector<Left> left;  ///< of places that the tool reaches and that lean over by 15 degrees or more
  double even_length = 0.0, ridge_length = 0.0, allowed = 0.0;
  Plan even, ridge;

  double most_even() const {
    double most = 0.0;
    for (const Left& l : left) most = std::max(most, l.even);
    return most;
  }
};

Plan plan_of(const CheckedMesh& part, PlanOptions o, StepMeasure measure) {
  o.pattern.measure = measure;
  auto planned = plan(part, o, nullptr);
  EXPECT_TRUE(planned) << planned.error().message;
  return planned ? std::move(*planned) : Plan{};
}

/// `half`: of the square of (x, y) in which places are looked at, mm.
Compared compare(const CheckedMesh& part, const PlanOptions& o, int places, double half) {
  Compared c;
  c.even = plan_of(part, o, StepMeasure::kFlat), c.ridge = plan_of(part, o, StepMeasure::kRidge);
  c.even_length = c.even.report.cut_length, c.ridge_length = c.ridge.report.cut_length;
  c.allowed = c.ridge.report.ridge;
  const double radius = o.cutter.radius();
  const sim::PartDistance solid(part.mesh), even(ball_track(c.even.path, radius)),
      ridge(ball_track(c.ridge.path, radius));
  const Deformation map(o.axis, 1.0);
  SurfaceSample surface(part.mesh);
  for (int i = 0; i < places; ++i) {
    const SurfaceSample::At at = surface.next();
    if (std::abs(at.point.x) > half || std::abs(at.point.y) > half) continue;
    const Point<Part> centre = at.point + at.normal * radius;
    const Vec3 axis = map.axis_at(centre);
    if (dot(at.normal, axis) < 0.26) continue;
    if (solid.nearest({centre, centre + axis * 30.0}, radius - 1e-6).facet != kNoFacet) continue;
    c.left.push_back({even.nearest(at.point).value - radius, ridge.nearest(at.point).value - radius});
  }
  return c;
}

/// `bent`: so many times as high a ridge may be, as the surface is not flat between two of the traced rows.
void expect_no_higher_ridges(const Compared& c, const PlanOptions& o, double bent = 1.05) {
  ASSERT_GT(c.left.size(), 1000u);
  EXPECT_GT(c.allowed, 0.0);
  // Both were found at some places each.
  EXPECT_LE(c.allowed, 1.1 * c.most_even() + o.tolerance / 2.0);
  std::size_t worse = 0;
  double most = 0.0;
  for (const Left& l : c.left) {
    worse += l.ridge > bent * std::max(c.allowed, l.even) + 0.4 * o.tolerance ? 1 : 0;
    most = std::max(most, l.ridge);
  }
  EXPECT_EQ(worse, 0u) << "of " << c.left.size();
  EXPECT_LE(most, 1.05 * std::max(c.allowed, c.most_even()) + 0.4 * o.tolerance);
}

PlanOptions fine_options(const AxisFrame& axis) {
  PlanOptions o = options_with(axis);
  o.pattern.side_step = 0.5, o.links.join_distance = 2.0, o.tolerance = 0.004;
  return o;
}

// Land, a slope of 60 degrees across the rows over half the width, and a cliff over the other half.
TEST(RidgeRows, ASlopeAndACliffAreFilled) {
  const CheckedMesh part = sheet(kUpright, {-20, 20, -20, 20, 160, 160}, [](double u, double v) {
    const double slope = std::clamp((v + 3.0) * 1.7320508, 0.0, 5.0);
    return u < 0.0 ? slope : v < -0.1 ? 0.0 : 5.0;
  });
  const PlanOptions o = fine_options(kUpright);
  const Compared c = compare(part, o, 12000, 16.0);
  expect_no_higher_ridges(c, o);
  EXPECT_LT(c.ridge_length, 0.75 * c.even_length);
  EXPECT_GT(c.ridge.report.passes, 1u);
}

// All rows must be as near to each other as they are.
TEST(RidgeRows, OnAPlaneNothingIsGained) {
  const CheckedMesh part = sheet(kUpright, {-20, 20, -20, 20, 1, 1}, [](double, double) { return 0.0; });
  const PlanOptions o = fine_options(kUpright);
  const Compared c = compare(part, o, 4000, 16.0);
  expect_no_higher_ridges(c, o);
  EXPECT_GT(c.ridge_length, 0.85 * c.even_length);
}

// Rows further apart on both sides of a slope begin and end no further from the borders than that.
TEST(RidgeRows, TheBordersOfTheContainmentAreCut) {
  const CheckedMesh part = sheet(kUpright, {-8, 8, -12, 12, 1, 96},
                                 [](double, double v) { return std::clamp(v * 1.7320508, 0.0, 1.0); });
  for (const double half : {6.0, 6.3, 6.6, 6.9, 7.2}) {
    SCOPED_TRACE(half);
    PlanOptions o = fine_options(kUpright);
    o.containment.second = {-half, half};
    expect_no_higher_ridges(compare(part, o, 20000, half - 0.001), o);
  }
}

// Waves across the rows, with the axis through a line.
TEST(RidgeRows, WavesRoundALine) {
  const AxisFrame axis{AxisMode::kLine, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};
  const CheckedMesh part = sheet(axis, {-12, 12, -0.6, 0.6, 60, 240}, [](double u, double v) {
    return 20.0 + 1.2 * std::sin(12.0 * v) * (u < 2.0 ? 1.0 : 0.2);
  });
  const PlanOptions o = fine_options(axis);
  const Compared c = compare(part, o, 12000, 9.0);
  // The ball is wider than the valleys.
  expect_no_higher_ridges(c, o, 1.2);
  EXPECT_LT(c.ridge_length, 0.9 * c.even_length);
}

// A roof of 1.5 x 3 mm with slopes of 60 degrees across the rows, on land.
TEST(RidgeRows, ALittleOfTheSurfaceDoesNotSayHowHighRidgesMayBe) {
  const CheckedMesh part = sheet(kUpright, {-20, 20, -20, 20, 160, 160}, [](double u, double v) {
    return std::abs(u) > 1.5 ? 0.0 : std::max(0.0, (0.75 - std::abs(v)) * 1.7320508);
  });
  PlanOptions o = fine_options(kUpright);
  const Compared c = compare(part, o, 12000, 16.0);
  expect_no_higher_ridges(c, o);
  const double radius = o.cutter.radius(), half = o.pattern.side_step / 2.0;
  const double of_land = radius - std::sqrt(radius * radius - half * half);
  EXPECT_GT(c.most_even(), 2.0 * of_land) << "the roof leaves no more than the land";
  EXPECT_NEAR(c.allowed, of_land, 0.1 * of_land + o.tolerance / 2.0);
}

// Where a long way over land ends the ball touches the pyramid: all of the way it touched the land.
TEST(RidgeRows, APyramidOnLandOfLargeFacets) {
  const CheckedMesh part = sheet(kUpright, {-20, 20, -20, 20, 10, 10}, [](double u, double v) {
    return 1.7320508 * std::max(0.0, 4.0 - std::max(std::abs(u), std::abs(v)));
  });
  PlanOptions o = fine_options(kUpright);
  o.pattern.scallop = 0.02;
  expect_no_higher_ridges(compare(part, o, 12000, 16.0), o);
}

TEST(RidgeRows, AGivenScallopIsNotExceeded) {
  const CheckedMesh part = sheet(kUpright, {-20, 20, -20, 20, 160, 160}, [](double u, double v) {
    return 2.0 * std::sin(0.4 * v) * std::cos(0.2 * u);
  });
  PlanOptions o = fine_options(kUpright);
  const double own = plan_of(part, o, StepMeasure::kRidge).report.ridge;
  for (const double share : {0.8, 1.1}) {
    o.pattern.scallop = share * own;
    const Compared c = compare(part, o, 6000, 16.0);
    EXPECT_EQ(c.allowed, o.pattern.scallop);
    expect_no_higher_ridges(c, o);
  }
  // No more than four times what the step leaves on a plane, and half the tolerance.
  const double radius = o.cutter.radius(), half = o.pattern.side_step / 2.0;
  o.pattern.scallop = radius / 2.0, o.pattern.measure = StepMeasure::kRidge;
  EXPECT_NEAR(plan_of(part, o, StepMeasure::kRidge).report.ridge,
              4.0 * (radius - std::sqrt(radius * radius - half * half)) + o.tolerance / 2.0, 1e-12);
}

TEST(RidgeRows, WhatTheyAreNotForIsRefused) {
  const CheckedMesh part = sheet(kUpright, {-8, 8, -8, 8, 1, 1}, [](double, double) { return 0.0; });
  const auto said = [&](const std::function<void(PlanOptions&)>& change) {
    PlanOptions o = fine_options(kUpright);
    o.pattern.measure = StepMeasure::kRidge;
    change(o);
    const auto planned = plan(part, o, nullptr);
    return planned ? std::string() : planned.error().message;
  };
  EXPECT_EQ(said([](PlanOptions&) {}), "");
  EXPECT_NE(said([](PlanOptions& o) { o.cutter.type = CutterType::kFlat; }).find("type ball"),
            std::string::npos);
  EXPECT_NE(said([](PlanOptions& o) { o.smoothing = 0.5; }).find("smoothing_mm"), std::string::npos);
  EXPECT_NE(said([](PlanOptions& o) { o.axial_stock = 0.5; }).find("axial_mm"), std::string::npos);
  EXPECT_NE(said([](PlanOptions& o) { o.pattern.kind = PatternKind::kContour; }).find("kind raster"),
            std::string::npos);
}

}  // namespace
}  // namespace tiltfeed
