// Bounds that the contact search leaves things out by are never above the truth: against balls all over
// random sheets, places all over random facets and boxes, in double.

#include "sim/removal/four_sheets.h"

#include <gtest/gtest.h>

#include <random>

namespace tiltfeed::sim {
using namespace pathgen;
namespace {

constexpr int kTrials = 3000, kCuts = 7;
constexpr double kBetween = 1.0 / (kCuts - 1);
// Far from the origin of the part, where single precision is coarse.
constexpr Point<Part> kOrigin{-347.0, 121.0, 59.0};

class Trial {
 public:
  explicit Trial(std::uint32_t seed) : random_(seed) {}
  double any(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 vector(double size) { return Vec3{any(-1, 1), any(-1, 1), any(-1, 1)} * size; }
  /// Short and long alike.
  double size(double least, double most) { return least * std::pow(most / least, any(0, 1)); }

 private:
  std::mt19937 random_;
};

struct Sheet4 {
  FourSheets four;
  std::array<Point<Part>, 4> foot;
  std::array<Vec3, 4> way{}, core{};
  std::array<double, 4> wide{};
  double radius = 0.0;

  Sheet4(Trial& t, bool with_core) : radius(t.size(0.3, 5.0)) {
    for (std::size_t i = 0; i < 4; ++i) {
      foot[i] = kOrigin + t.vector(6.0), way[i] = t.vector(t.size(1e-3, 8.0)), wide[i] = t.size(1e-3, 0.5);
      if (with_core) core[i] = t.vector(t.size(1e-2, 40.0));
      if (with_core && i == 3) core[i] = way[i] * t.any(-3.0, 3.0);
      if (i == 2 && t.any(0, 1) < 0.2) way[i] = {};
      four.set(static_cast<int>(i), kOrigin, foot[i], way[i], core[i], wide[i], radius);
    }
  }
  /// Of the ball's centres.
  template <class Visit>
  void each(std::size_t i, const Visit& visit) const {
    for (int a = 0; a < kCuts; ++a)
      for (int b = 0; b < (core[i] == Vec3{} ? 1 : kCuts); ++b)
        visit(foot[i] + way[i] * (a * kBetween) + core[i] * (b * kBetween));
  }
};

struct OneFacet {
  Probes probes;
  Facet facet;

  explicit OneFacet(const Mesh& mesh)
      : probes(mesh, 1e3, 1.0), facet(probes.patches(), probes.surface().triangle(0), 0) {}
  static Mesh near(Trial& t) {
    Mesh mesh;
    const double size = t.size(0.05, 10.0);
    const Point<Part> at = kOrigin + t.vector(9.0);
    mesh.vertices = {at, at + t.vector(size), at + t.vector(size)};
    mesh.facets = {{0, 1, 2}};
    return mesh;
  }
  template <class Visit>
  void each(const Visit& visit) const {
    const Triangle& t = probes.surface().triangle(0);
    for (int a = 0; a < kCuts; ++a)
      for (int b = 0; a + b < kCuts; ++b) visit(t.a + t.ab * (a * kBetween) + t.ac * (b * kBetween));
  }
};

TEST(FourSheets, NothingIsLeftLowerThanTheirBounds) {
  Trial t(1);
  int near = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Sheet4 sheets(t, trial % 4 != 0);
    const OneFacet one(OneFacet::near(t));
    const FacetLanes facet(kOrigin, one.facet);
    const FourSheets& four = sheets.four;
    const Lanes over = four.over(facet), value = over + risen(four.beyond(facet), four.radius);
    const FourSheets::Left left = four.left(facet, facet.middle, facet.radius);
    for (std::size_t i = 0; i < 4; ++i) {
      const double ball = sheets.radius + sheets.wide[i];
      // Of lines that start outside of a ball, what is below their feet does not matter.
      double least = kInfinity, above = kInfinity, gap = kInfinity, high = kInfinity;
      one.each([&](Point<Part> foot) {
        sheets.each(i, [&](Point<Part> centre) {
          const Vec3 m = foot - centre;
          const double rise = dot(m, one.facet.normal), root2 = rise * rise - squared_length(m) + ball * ball;
          gap = std::min(gap, length(m) - ball), high = std::min(high, -rise - ball);
          if (root2 < 0.0) return;
          const double enter = -rise - std::sqrt(root2);
          least = std::min(least, enter);
          if (enter >= 0.0) above = std::min(above, enter);
        });
      });
      EXPECT_LE(static_cast<double>(over[i]), high) << trial;
      EXPECT_LE(static_cast<double>(value[i]), least) << trial;
      EXPECT_LE(static_cast<double>(left.gap[i]), gap) << trial;
      EXPECT_LE(static_cast<double>(left.least[i]), gap < 0.0 ? -1e29 : above) << trial;
      if (least < kInfinity && least - static_cast<double>(value[i]) < 0.2) ++near;
    }
  }
  EXPECT_GT(near, kTrials / 10);
}

TEST(FourSheets, PlacesBesideAWayAreAsFarAtLeast) {
  Trial t(2);
  int near = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Sheet4 sheets(t, false);
    const OneFacet one(OneFacet::near(t));
    const FacetLanes facet(kOrigin, one.facet);
    const Vec3 n = one.facet.normal;
    one.each([&](Point<Part> place) {
      const Lanes beside = sheets.four.beside(facet, sheets.four.trace(facet), all_lanes(place - kOrigin));
      for (std::size_t i = 0; i < 4; ++i) {
        double least = kInfinity;
        sheets.each(i, [&](Point<Part> centre) {
          const Vec3 m = centre - place;
          least = std::min(least, length(m - n * dot(n, m)) - sheets.wide[i]);
        });
        ASSERT_LE(static_cast<double>(beside[i]), least) << trial;
        if (least - static_cast<double>(beside[i]) < 0.01 * (1.0 + least)) ++near;
      }
    });
  }
  EXPECT_GT(near, 20 * kTrials);
}

TEST(FourSheets, BoxesAreAsFarAtLeast) {
  Trial t(3);
  int near = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Sheet4 sheets(t, trial % 4 != 0);
    const Vec3 middle = t.vector(30.0), half{t.size(0.01, 20.0), t.size(0.01, 20.0), t.size(0.01, 20.0)};
    const Lanes bound = sheets.four.distance(middle, half);
    for (std::size_t i = 0; i < 4; ++i) {
      double least = kInfinity;
      sheets.each(i, [&](Point<Part> centre) {
        const Vec3 m = centre - kOrigin - middle;
        const auto off = [](double from, double size) { return std::max(0.0, std::abs(from) - size); };
        least = std::min(least, length({off(m.x, half.x), off(m.y, half.y), off(m.z, half.z)}));
      });
      least -= sheets.radius + sheets.wide[i];
      ASSERT_LE(static_cast<double>(bound[i]), least) << trial;
      if (least > 0.0 && static_cast<double>(bound[i]) > 0.8 * least) ++near;
    }
  }
  EXPECT_GT(near, kTrials / 2);
}

TEST(Facet, ASegmentThatMeetsNotIsAsFarAtLeast) {
  Trial t(4);
  int far = 0, left_out = 0;
  for (int trial = 0; trial < 20 * kTrials; ++trial) {
    const OneFacet one(OneFacet::near(t));
    const Point<Part> from = one.facet.middle + t.vector(t.size(0.1, 12.0));
    const Segment s{from, from + t.vector(t.size(1e-3, 12.0))};
    const double near = t.size(0.01, 10.0);
    const double distance = std::sqrt(squared_distance(one.probes.surface().triangle(0), s));
    const bool meets = one.facet.meets(s, near);
    EXPECT_GE(meets ? near : distance, near - 1e-6) << trial;
    if (distance >= near) ++far;
    if (!meets) ++left_out;
  }
  // What is nearest to a corner, or pierces the plane, may be kept.
  EXPECT_GT(left_out, 0.8 * far);
}

}  // namespace
}  // namespace tiltfeed::sim
