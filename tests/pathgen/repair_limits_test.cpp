#include <gtest/gtest.h>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/mesh/repair.h"
#include "tests/shapes/damage.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using namespace soup;
using namespace damage;

/// Left as it is: the mesh, the sides and the counts are those without repair, and the reason is given.
void expect_left(const Soup& soup, const std::string& reason) {
  const CheckedMesh mesh = check(soup);
  const Result<CheckedMesh> bare = check_mesh(stl_of(soup), {.distance = 0.0});
  ASSERT_TRUE(bare);
  EXPECT_EQ(mesh.sides, Sides::kBoth);
  EXPECT_EQ(mesh.mesh.facets, bare->mesh.facets);
  EXPECT_EQ(mesh.mesh.vertices, bare->mesh.vertices);
  EXPECT_EQ(counts(mesh), counts(*bare));
  ASSERT_FALSE(mesh.warnings.empty());
  EXPECT_NE(mesh.warnings[0].find("not repaired: "), std::string::npos) << mesh.warnings[0];
  EXPECT_NE(mesh.warnings[0].find(reason), std::string::npos) << mesh.warnings[0];
  EXPECT_EQ(bare->warnings[0].find("not repaired"), std::string::npos) << bare->warnings[0];
}

/// A tube of `n` walls without ends.
Soup tube(int n) {
  const auto at = [n](int i, double z) {
    return Point<Part>{5 * std::cos(2 * M_PI * (i % n) / n), 5 * std::sin(2 * M_PI * (i % n) / n), z};
  };
  Soup s;
  for (int i = 0; i < n; ++i) add_quad(s, at(i, 0), at(i + 1, 0), at(i + 1, 9), at(i, 9));
  return s;
}

TEST(RepairLimits, PortsStayOpen) {
  expect_left(tube(3), "would turn by 90 degrees");
  expect_left(tube(4), "would turn by 90 degrees");
  expect_left(tube(5), "has 5 edges, and only holes of at most 4");
  expect_left(tube(40), "has 40 edges");
  Soup tray = cube(0, 2);
  tray.erase(tray.begin() + 2, tray.begin() + 4);
  expect_left(tray, "would turn by 90 degrees");
  Soup holed = torus();  // all or nothing
  holed.erase(holed.begin() + 5);
  expect_left(holed + tube(12), "has 12 edges");
  expect_left({torus()[0]}, "");
}

TEST(RepairLimits, GapsBeyondTheDistanceStayOpen) {
  Random random(5);
  Soup broken = torus();
  crack(broken, 10 * kDistance, random);
  expect_left(broken, "");
  const Result<CheckedMesh> wide = check_mesh(stl_of(broken), {.distance = 200 * kDistance});
  ASSERT_TRUE(wide);
  EXPECT_EQ(wide->sides, Sides::kOutward);
  EXPECT_LT(hausdorff(corners_of(wide->mesh), torus()), 10 * kDistance * std::sqrt(3.0) + 100 * kDistance);
}

TEST(RepairLimits, FillsThatWouldCrossAreNotMade) {
  Soup holed = torus();
  const auto [a, b, c] = holed[40];
  holed.erase(holed.begin() + 40);
  const Point<Part> centre = lerp(lerp(a, b, 0.5), c, 1.0 / 3);
  const Vec3 n = normalized(cross(b - a, c - a));
  Soup needle;  // through the middle of the hole
  const Vec3 u = normalized(b - a) * 0.1, v = cross(n, u);
  const Point<Part> foot = centre - n * 0.3, tip = centre + n * 0.5;
  const Point<Part> p = foot + u, q = foot + v, r = foot - u - v;
  needle = {{p, r, q}, {p, q, tip}, {q, r, tip}, {r, p, tip}};
  ASSERT_GT(volume_of(needle), 0.0);
  expect_left(holed + needle, "pairs of facets would cross that do not in the file");
  for (Corners& f : needle)  // beside the hole
    for (Point<Part>& corner : f) corner = corner + n * 3.0;
  EXPECT_EQ(check(holed + needle).sides, Sides::kOutward);
  // What crossed before may go on crossing.
  for (Corners& f : needle)
    for (Point<Part>& corner : f) corner = corner - n * 3.0;
  Soup elsewhere = torus();
  elsewhere.erase(elsewhere.begin() + 120);
  Random random(1);
  crack(elsewhere, 1e-4, random);
  EXPECT_EQ(check(elsewhere + needle).sides, Sides::kOutward);
}

TEST(RepairLimits, WallsAndFinsStay) {
  // A wall between two rooms: three facets on each of its edges.
  expect_left(cube(0, 2) + Soup{{{{0, 0, 0}, {2, 2, 0}, {2, 2, 2}}}, {{{0, 0, 0}, {2, 2, 2}, {0, 0, 2}}}},
              "");
  const double height = 2 * kDistance;
  expect_left(cube(0, 2) + Soup{{{{2, 0, 2}, {2, 2, 2}, {2 + height, 1, 2 + height}}}}, "facets");
}

/// A fin of no thickness on the edge (2, 0, 2) - (2, 2, 2) of a cube: two facets, their tips a crack apart.
Soup cube_with_fin(double height) {
  const Point<Part> p{2, 0, 2}, q{2, 2, 2}, tip{2 + height, 1, 2 + height};
  return cube(0, 2) + Soup{{{p, q, tip}}, {{q, p, tip + Vec3{1e-4, 0, 0}}}};
}

TEST(RepairLimits, ThinFinsStayUnlessWithinTheDistance) {
  expect_left(cube_with_fin(1.0), "");
  EXPECT_EQ(check(cube_with_fin(kDistance / 4)).sides, Sides::kOutward);
}

/// A box of 10 x 4 x 2 whose front goes round the points given, while its top has one straight edge there.
Soup box_with_steps(const std::vector<Point<Part>>& steps) {
  Soup s = box({0, 0, 0}, {10, 4, 2});
  s.erase(s.begin() + 4, s.begin() + 6);  // y = 0
  std::vector<Point<Part>> upper{{0, 0, 2}};
  upper.insert(upper.end(), steps.begin(), steps.end());
  upper.push_back({10, 0, 2});
  s.push_back({{{0, 0, 0}, {10, 0, 0}, {10, 0, 2}}});
  for (std::size_t i = 0; i + 1 < upper.size(); ++i) s.push_back({{{0, 0, 0}, upper[i + 1], upper[i]}});
  return s;
}

TEST(RepairLimits, StepsDoNotAddUpBeyondTheDistance) {
  const double low = 2 - 0.4 * kDistance, lower = 2 - 0.8 * kDistance, lowest = 2 - 1.2 * kDistance;
  const Soup two =
      box_with_steps({{3, 0, low}, {3.5, 0, lower}});  // the second is near the first's edge only
  const CheckedMesh mesh = check(two);
  EXPECT_EQ(mesh.sides, Sides::kOutward);
  EXPECT_LE(hausdorff(corners_of(mesh.mesh), two), 0.8 * kDistance * (1 + 1e-9));
  expect_left(box_with_steps({{3, 0, low}, {3.5, 0, lower}, {4, 0, lowest}}),
              "would move by more than the distance");
}

}  // namespace
}  // namespace tiltfeed
