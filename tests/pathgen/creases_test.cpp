// Creases of the CL surface against closed forms.
#include "pathgen/creases/creases.h"

#include <gtest/gtest.h>

#include "tests/shapes/crease_shapes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kSharp = 2e-6;  ///< a kink's place is known to kKinkStep

double total_length(const std::vector<Crease>& creases) {
  double sum = 0.0;
  for (const Crease& crease : creases) sum += crease_length(crease);
  return sum;
}

/// Two half planes that meet in the line from `at` along `edge`, leaning by a and b (degrees) from the plane
/// square to `up`.
struct Valley {
  Point<Part> at;
  Vec3 edge, up;
  double a, b, half_length, width;
  Vec3 side(double sign) const {
    const Vec3 across = cross(up, edge);
    const double lean = (sign > 0.0 ? a : b) / 180.0 * kPi;
    return across * (sign * std::cos(lean)) + up * std::sin(lean);
  }
  /// Half of the angle between the planes, over the material-free side.
  double half_angle() const { return (180.0 - a - b) / 360.0 * kPi; }
  Shapes shapes() const {
    Shapes s;
    const Point<Part> p = at - edge * half_length, q = at + edge * half_length;
    s.quad(p, p + side(1.0) * width, q + side(1.0) * width, q);
    s.quad(p, q, q + side(-1.0) * width, p + side(-1.0) * width);
    for (auto& f : s.mesh.facets) {  // so that `up` is outside
      const Point<Part> o = s.mesh.vertices[f[0]];
      if (dot(cross(s.mesh.vertices[f[1]] - o, s.mesh.vertices[f[2]] - o), up) < 0.0) std::swap(f[1], f[2]);
    }
    return s;
  }
};

TEST(Creases, OfABallBetweenTwoPlanesLieRadiusOverSineOfTheHalfAngleFromTheEdge) {
  const Vec3 edge = normalized(Vec3{1.0, 0.4, 0.08});
  const Vec3 up = normalized(Vec3{-0.1, 0.05, 1.0} - edge * dot(edge, Vec3{-0.1, 0.05, 1.0}));
  double worst = 0.0;
  for (const ModeCase& mode : mode_cases())
    for (const auto& [a, b] : {std::pair{45.0, 45.0}, {20.0, 60.0}, {10.0, 15.0}, {0.0, 65.0}}) {
      const Valley valley{{0.3, -0.2, 0.1}, edge, up, a, b, 9.0, 12.0};
      const Shapes shapes = valley.shapes();
      const auto field = field_of_tool(shapes.mesh, mode.frame, crease_tool(CutterType::kBall, 4.0), 37.0);
      const auto creases = creases_over(*field, 4.0);
      const Vec3 to_centre = normalized(normalized(valley.side(1.0)) + normalized(valley.side(-1.0)));
      // Both planes' creases, and beyond their ends those round corners: only what is well inside counts.
      std::size_t inside = 0;
      double length = 0.0;
      for (const Crease& crease : creases)
        for (std::size_t i = 0; i < crease.size(); ++i) {
          const Vec3 d = crease[i].point.centre - valley.at;
          const double along = dot(d, edge);
          if (std::abs(along) > 8.5) continue;
          const double off =
              distance(crease[i].point.centre,
                       valley.at + edge * along + to_centre * (2.0 / std::sin(valley.half_angle())));
          worst = std::max(worst, off);
          EXPECT_LT(off, 2.0 * kSharp) << mode.name << ' ' << a << ' ' << b << " at " << along;
          ++inside;
          if (i > 0 && std::abs(dot(crease[i - 1].point.centre - valley.at, edge)) <= 8.5)
            length += distance(crease[i].point.centre, crease[i - 1].point.centre);
        }
      EXPECT_GT(inside, 10u) << mode.name;
      EXPECT_GT(length, 15.0) << mode.name << ' ' << a << ' ' << b;
      EXPECT_LT(length, 17.001) << mode.name << ' ' << a << ' ' << b;
    }
  std::printf("largest distance from r / sin(half): %.2g mm\n", worst);
}

TEST(Creases, OfABullNoseAndAFlatEndStandOffTheFootOfALeaningWall) {
  double worst = 0.0;
  for (const double lean : {30.0, 60.0, 85.0, 90.0})
    for (const double corner : {0.0, 0.5, 1.3, 3.0}) {
      Shapes shapes;
      const double w = lean / 180.0 * kPi, h = 14.0;
      const Point<Part> top{h * std::cos(w), 0, h * std::sin(w)};
      shapes.floor(-15, -10, 0, 10, 0.0);
      shapes.quad({0, -10, 0}, {top.x, -10, top.z}, {top.x, 10, top.z}, {0, 10, 0});
      if (lean == 90.0) shapes.floor(0, -10, 8, 10, top.z);
      const CutterType type = corner == 0.0   ? CutterType::kFlat
                              : corner == 3.0 ? CutterType::kBall
                                              : CutterType::kBullNose;
      const auto field = field_of_tool(shapes.mesh, {}, crease_tool(type, 6.0, corner));
      const auto creases = creases_over(*field, 6.0, 10.0, FlatBounds{-12.0, 12.0, -6.5, 6.5});
      // The ring round the axis touches the wall corner off it: x sin w = -(corner (1 - cos w) + flat sin w).
      const double x = -(3.0 - corner) - corner * std::tan(w / 2.0);
      ASSERT_EQ(creases.size(), 1u) << lean << ' ' << corner;
      EXPECT_NEAR(crease_length(creases[0]), 13.0, 1e-3);
      for (const CreaseNode& node : creases[0]) {
        worst = std::max(worst, std::abs(node.point.centre.x - x));
        // (C4) a sharp edge is widened by kSeam.
        EXPECT_NEAR(node.point.centre.x, x, kSharp + 2e-5 * 6.0) << lean << ' ' << corner;
        EXPECT_NEAR(node.point.centre.z, corner, 2e-5) << lean << ' ' << corner;
        EXPECT_EQ(node.steep, lean >= 60.0);
        EXPECT_TRUE(!node.steep || node.aside[0] < 0.0);
      }
    }
  std::printf("largest distance from the foot of the wall: %.2g mm\n", worst);
}

TEST(Creases, OfCylindersOnAPlaneAreTheirOffsetOnIt) {
  constexpr int kCount = 720;
  const double sagitta = 5.0 * (1.0 - std::cos(kPi / kCount));
  {  // standing: a circle round it
    Shapes shapes;
    shapes.floor(-20, -20, 20, 20, 0.0);
    shapes.revolve(1.0, 2.0, {{5.0, 0.0}, {5.0, 9.0}, {0.0, 9.0}}, kCount);
    const auto field = field_of_tool(shapes.mesh, {}, crease_tool(CutterType::kBall, 4.0));
    const auto creases = creases_over(*field, 4.0, 10.0, FlatBounds{-15, 15, -15, 15});
    ASSERT_EQ(creases.size(), 1u);
    EXPECT_EQ(creases[0].front().point.centre, creases[0].back().point.centre);
    EXPECT_NEAR(crease_length(creases[0]), 2.0 * kPi * 7.0, 0.01);
    for (const CreaseNode& n : creases[0]) {
      EXPECT_NEAR(n.point.centre.z, 2.0, 1e-9);
      EXPECT_NEAR(std::hypot(n.point.centre.x - 1.0, n.point.centre.y - 2.0), 7.0, sagitta + kSharp);
    }
  }
  {  // lying, its axis 3 mm over the plane: a line on each side
    Shapes shapes;
    shapes.floor(-20, -12, 20, 12, 0.0);
    for (int i = 0; i < kCount; ++i) {
      const auto at = [&](int k, double y) {
        const double turn = 2.0 * kPi * k / kCount;
        return Point<Part>{5.0 * std::cos(turn), y, 3.0 + 5.0 * std::sin(turn)};
      };
      shapes.quad(at(i, -12), at(i, 12), at(i + 1, 12), at(i + 1, -12));
    }
    for (auto& f : shapes.mesh.facets) {
      const Point<Part> a = shapes.mesh.vertices[f[0]];
      const Vec3 n = cross(shapes.mesh.vertices[f[1]] - a, shapes.mesh.vertices[f[2]] - a);
      if (a.z > 1e-9 && dot(n, Vec3{a.x, 0.0, a.z - 3.0}) < 0.0) std::swap(f[1], f[2]);
    }
    const auto field = field_of_tool(shapes.mesh, {}, crease_tool(CutterType::kBall, 4.0));
    const auto creases = creases_over(*field, 4.0, 10.0, FlatBounds{-15, 15, -8, 8});
    ASSERT_EQ(creases.size(), 2u);
    for (const Crease& crease : creases)
      for (const CreaseNode& n : crease) {
        // The ball touches it below its middle where 3 - 5 < 2: beside a wall that hangs over.
        EXPECT_NEAR(n.point.centre.z, 2.0, 1e-9);
        EXPECT_NEAR(std::abs(n.point.centre.x), 7.0, sagitta + kSharp);
      }
  }
}

TEST(Creases, OfABoxCornerMeetWhereTheBallTouchesAllThreeSides) {
  AxisFrame frame;
  frame.n = normalized(Vec3{1, 1, 1}), frame.t = normalized(Vec3{1, -1, 0});
  Shapes shapes;
  shapes.quad({0, 0, 0}, {30, 0, 0}, {30, 30, 0}, {0, 30, 0});
  shapes.quad({0, 0, 0}, {0, 30, 0}, {0, 30, 30}, {0, 0, 30});
  shapes.quad({0, 0, 0}, {0, 0, 30}, {30, 0, 30}, {30, 0, 0});
  const auto field = field_of_tool(shapes.mesh, frame, crease_tool(CutterType::kBall, 4.0));
  const auto creases = creases_over(*field, 4.0, 10.0, FlatBounds{-8.1, 8.2, -8.3, 8.4});
  ASSERT_EQ(creases.size(), 3u);
  for (const Crease& crease : creases) {
    const Point<Part> a = crease.front().point.centre, b = crease.back().point.centre;
    EXPECT_LT(std::min(distance(a, {2, 2, 2}), distance(b, {2, 2, 2})), 2.0 * kLeastCreaseCell);
    EXPECT_GT(crease_length(crease), 6.0);
    for (const CreaseNode& n : crease) {
      const Point<Part> c = n.point.centre;
      std::array<double, 3> xyz{c.x, c.y, c.z};
      std::sort(xyz.begin(), xyz.end());
      EXPECT_NEAR(xyz[0], 2.0, 2.0 * kSharp);
      EXPECT_NEAR(xyz[1], 2.0, 2.0 * kLeastCreaseCell);
    }
  }
}

TEST(Creases, RunRoundTheFloorOfAPocketWithUprightWalls) {
  Shapes shapes;
  shapes.floor(0, 0, 20, 14, 0.0);
  const auto wall = [&](Point<Part> a, Point<Part> b) {
    shapes.quad(b, a, {a.x, a.y, 10.0}, {b.x, b.y, 10.0});
  };
  wall({0, 0, 0}, {20, 0, 0}), wall({20, 0, 0}, {20, 14, 0}), wall({20, 14, 0}, {0, 14, 0}),
      wall({0, 14, 0}, {0, 0, 0});
  shapes.floor(-10, -10, 30, 0, 10.0), shapes.floor(-10, 14, 30, 24, 10.0);
  shapes.floor(-10, 0, 0, 14, 10.0), shapes.floor(20, 0, 30, 14, 10.0);
  for (const CutterType type : {CutterType::kBall, CutterType::kFlat, CutterType::kBullNose}) {
    const auto field = field_of_tool(shapes.mesh, {}, crease_tool(type, 4.0, 0.5));
    auto creases = creases_over(*field, 4.0, 10.0, FlatBounds{-8, 28, -8, 22});
    // A round cutter also rolls into the upright corners over their upper edges.
    const std::size_t all = creases.size();
    std::erase_if(creases, [](const Crease& crease) { return crease.front().point.centre.z > 5.0; });
    EXPECT_EQ(all - creases.size(), type == CutterType::kBall ? 4u : 0u);
    ASSERT_EQ(creases.size(), 1u);
    EXPECT_EQ(creases[0].front().point.centre, creases[0].back().point.centre);
    EXPECT_NEAR(crease_length(creases[0]), 2.0 * (16.0 + 10.0), 0.02);
    for (const CreaseNode& n : creases[0]) {
      const double x = n.point.centre.x, y = n.point.centre.y;
      EXPECT_LT(n.point.centre.z, 2.0 + 1e-9);
      EXPECT_NEAR(std::min({x - 2.0, 18.0 - x, y - 2.0, 12.0 - y}), 0.0, 2e-5 * 6.0);
    }
  }
}

TEST(Creases, EndWhereBothContactsMerge) {
  // A valley whose fillet grows along y from nothing to twice the ball's radius.
  Shapes shapes;
  constexpr int kSteps = 60, kRows = 80;
  const auto at = [&](int k, double y) {
    const double radius = 4.0 * y / 40.0;
    if (k == 0) return Point<Part>{-20, y, 20};
    if (k == kSteps + 2) return Point<Part>{20, y, 20};
    const double turn = kPi / 4.0 + kPi / 2.0 * (k - 1) / kSteps;  // from the left plane to the right
    return Point<Part>{-radius * std::cos(turn), y, radius * (std::sqrt(2.0) - std::sin(turn))};
  };
  for (int row = 0; row < kRows; ++row)
    for (int k = 0; k < kSteps + 2; ++k) {
      const double y0 = 40.0 * row / kRows, y1 = 40.0 * (row + 1) / kRows;
      if (row == 0 && k > 0 && k < kSteps + 1) {
        shapes.facet(at(k, y0), at(k + 1, y1), at(k, y1));
        continue;
      }
      shapes.quad(at(k, y0), at(k + 1, y0), at(k + 1, y1), at(k, y1));
    }
  const auto field = field_of_tool(shapes.mesh, {}, crease_tool(CutterType::kBall, 4.0));
  const auto creases = creases_over(*field, 4.0, 10.0, FlatBounds{-6, 6, 3, 38});
  ASSERT_EQ(creases.size(), 1u);
  double last = 0.0;
  for (const CreaseNode& n : creases[0]) last = std::max(last, n.point.centre.y);
  EXPECT_NEAR(last, 20.0, 0.3);
}

TEST(Creases, AreNotFoundOnSmoothPartsHoweverFineTheMesh) {
  for (const int count : {48, 96, 192}) {
    Shapes sphere, hollow;
    sphere.bead(0, 0, 0, 12, 0, false, count);
    {
      std::vector<std::array<double, 2>> bowl;
      for (int k = 0; k <= count / 4; ++k) {
        const double turn = kPi / 2.0 * k / (count / 4);
        bowl.push_back({12.0 * std::sin(turn), -12.0 * std::cos(turn)});
      }
      bowl.front()[0] = 0.0;
      hollow.revolve(0, 0, bowl, count);
      for (auto& f : hollow.mesh.facets) {
        const Point<Part> a = hollow.mesh.vertices[f[0]];
        const Vec3 n = cross(hollow.mesh.vertices[f[1]] - a, hollow.mesh.vertices[f[2]] - a);
        if (dot(n, Vec3{a.x, a.y, a.z}) > 0.0) std::swap(f[1], f[2]);
      }
    }
    Shapes torus;
    torus.bead(0, 0, 14, 6, 0, true, count);
    AxisFrame point, circle;
    point.mode = AxisMode::kPoint, point.origin = {0, 0, 0};
    circle.mode = AxisMode::kCircle, circle.circle_radius = 14.0, circle.n = {1, 0, 0}, circle.t = {0, 1, 0};
    const struct {
      const char* name;
      const Mesh& mesh;
      AxisFrame frame;
      FlatBounds bounds;
    } cases[] = {{"sphere, fixed", sphere.mesh, {}, {-9, 9, -9, 9}},
                 {"sphere, point", sphere.mesh, point, {-20, 20, 2, 15}},
                 {"bowl, fixed", hollow.mesh, {}, {-7, 7, -7, 7}},
                 {"torus, fixed", torus.mesh, {}, {-18, 18, -18, 18}},
                 {"torus, circle", torus.mesh, circle, {-20, 20, 2, 8}}};
    for (const auto& c : cases)
      for (const CutterType type : {CutterType::kBall, CutterType::kBullNose, CutterType::kFlat}) {
        if (type != CutterType::kBall && c.frame.mode == AxisMode::kPoint) continue;
        const auto field = field_of_tool(c.mesh, c.frame, crease_tool(type, 4.0, 1.0), 12.0);
        const auto creases = creases_over(*field, 4.0, 10.0, c.bounds);
        EXPECT_EQ(total_length(creases), 0.0) << c.name << ' ' << count << " type " << static_cast<int>(type);
      }
  }
}

}  // namespace
}  // namespace tiltfeed
