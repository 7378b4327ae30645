// Each built-in part has the features of its description, read off its facets.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/parts/parts.h"
#include "tests/shapes/welded.h"

namespace tiltfeed::sim {
namespace {

constexpr double kOneDegree = std::numbers::pi / 180.0;

/// About the tyre's centre circle, degrees and mm.
struct TorusPoint {
  double theta, phi, height;
};
TorusPoint on_torus(Point<Part> p) {
  const double g = std::hypot(p.x, p.z) - 280.0;
  return {std::atan2(p.x, -p.z) / kOneDegree, std::atan2(p.y, g) / kOneDegree, 90.0 - std::hypot(g, p.y)};
}

Triangles cavity_of(const Triangles& tyre) {
  constexpr double kRounding = 1e-3, kSectorFace = 20.0 - 1e-5;
  Triangles cavity;
  for (const auto& triangle : tyre) {
    int on_cavity = 0, on_face = 0;
    for (const Point<Part>& p : triangle) {
      const TorusPoint at = on_torus(p);
      on_cavity += at.height > -kRounding;
      on_face += std::abs(at.theta) > kSectorFace;
    }
    if (on_cavity == 3 && on_face < 3) cavity.push_back(triangle);
  }
  return cavity;
}

TEST(Tyre, CavityIsATorusWithDraftedRibs) {
  const Triangles cavity = cavity_of(tyre_segment());
  EXPECT_GT(cavity.size(), 100'000u);
  double walls = 0.0, flats = 0.0;
  for (const auto& triangle : cavity) {
    Vec3 middle;
    for (const Point<Part>& p : triangle) {
      const TorusPoint at = on_torus(p);
      ASSERT_LE(at.height, 8.0 + 1e-4);
      ASSERT_LE(std::abs(at.phi), 55.0 + 1e-4);
      ASSERT_LE(std::abs(at.theta), 20.0 + 1e-4);
      middle = middle + from_origin(p) / 3.0;
    }
    const Vec3 doubled = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    const Vec3 circle = Vec3{middle.x, 0.0, middle.z} * (280.0 / std::hypot(middle.x, middle.z));
    const double slope = angle_between(doubled, circle - middle) / kOneDegree;
    const bool wall = slope > 45.0;
    EXPECT_NEAR(slope, wall ? 85.0 : 0.0, wall ? 0.6 : 0.7);  // no undercut: 90
    (wall ? walls : flats) += 0.5 * length(doubled);
  }
  EXPECT_GT(walls, 0.5 * flats);
}

/// Heights where the plane Phi = phi cuts the cavity, in order of Theta: how often they come up to `level`.
int count_rises(const Triangles& cavity, double level, bool along_theta, double at) {
  std::vector<std::pair<double, double>> profile;
  for (const auto& triangle : cavity) {
    for (int i = 0; i < 3; ++i) {
      const TorusPoint a = on_torus(triangle[i]), b = on_torus(triangle[(i + 1) % 3]);
      const double from = along_theta ? a.phi : a.theta, to = along_theta ? b.phi : b.theta;
      if ((from < at) == (to < at)) continue;
      const double f = (at - from) / (to - from);
      const double x = along_theta ? a.theta + f * (b.theta - a.theta) : a.phi + f * (b.phi - a.phi);
      profile.push_back({x, a.height + f * (b.height - a.height)});
    }
  }
  std::sort(profile.begin(), profile.end());
  int rises = 0;
  bool up = false;
  for (const auto& [x, height] : profile) {
    if (!up && height > level - 0.02) ++rises;
    up = height > level - 0.02 || (up && height > 0.5);
  }
  return rises;
}

TEST(Tyre, TreadHasItsRibsAndBlades) {
  const Triangles cavity = cavity_of(tyre_segment());
  const auto along = [&](double phi, double level) { return count_rises(cavity, level, true, phi); };
  EXPECT_EQ(count_rises(cavity, 8.0, false, -19.9), 4);  // circumferential, at a sector face
  EXPECT_EQ(along(2.0, 5.0), 9);                         // centre row
  EXPECT_EQ(along(2.0, 5.5), 0);
  for (const double phi : {-22.0, 22.0, -45.0, 45.0}) {
    EXPECT_EQ(along(phi, 7.0), 9) << phi;
    EXPECT_EQ(along(phi, 4.0), 18) << phi;  // with the blades
    EXPECT_EQ(along(phi, 7.5), 0) << phi;
  }
  EXPECT_EQ(along(53.0, 0.5), 0);
}

TEST(Sphere, EveryVertexIsOnAShellOrABore) {
  const double third = std::sqrt(1.0 / 3.0), sixth = std::sqrt(1.0 / 6.0), half = std::sqrt(0.5);
  const Vec3 axes[] = {{0, 2 * sixth, third}, {-half, -sixth, third}, {half, -sixth, third}};
  int outer = 0, inner = 0, rims = 0, bores = 0;
  for (const Point<Part>& p : weld(hollow_sphere()).vertices) {
    const Vec3 v = from_origin(p);
    double to_bore = 1e9;
    for (const Vec3& axis : axes)
      if (dot(v, axis) > 0.0) to_bore = std::min(to_bore, length(cross(v, axis)));
    EXPECT_GT(to_bore, 18.0 - 1e-4);
    const bool on_outer = std::abs(length(v) - 50.0) < 1e-4, on_inner = std::abs(length(v) - 40.0) < 1e-4;
    const bool on_bore = std::abs(to_bore - 18.0) < 1e-4;
    ASSERT_TRUE(on_outer || on_inner || on_bore);
    outer += on_outer;
    inner += on_inner;
    rims += on_bore && (on_outer || on_inner);
    bores += on_bore;
  }
  EXPECT_EQ(rims, 3 * 2 * 48);
  EXPECT_EQ(bores, 3 * 3 * 48);
  EXPECT_GT(outer, inner);
}

TEST(Pin, WingsStandOnThePipe) {
  int tips = 0, bore = 0;
  for (const Point<Part>& p : weld(cooling_pin()).vertices) {
    const double r = std::hypot(p.x, p.z);
    const bool on_tip = std::abs(r - 23.0) < 1e-4;
    tips += on_tip;
    bore += std::abs(r - 7.0) < 1e-4;
    if (r < 10.0 + 1e-4) continue;
    // Within 1 mm of one of the twelve radial planes, and in one of the six rings.
    const double angle = std::atan2(p.x, p.z),
                 nearest = 30.0 * kOneDegree * std::round(angle / (30.0 * kOneDegree));
    EXPECT_LT(std::abs(r * std::sin(angle - nearest)), 1.0 + 1e-4);
    EXPECT_LE(std::fmod(p.y - 3.0, 10.0), 6.0);
  }
  EXPECT_EQ(tips, 72 * 4 * 7);
  EXPECT_EQ(bore, 84 * 63);
}

TEST(Handle, HasGroovesARestAndFlatFeet) {
  const Welded mesh = weld(handle());
  const auto underside = [&](double x) {  // the vertex nearest to x below the grip's centre line
    double best = 1e9, z = 0.0;
    for (const Point<Part>& p : mesh.vertices)
      if (std::abs(p.y) < 0.5 && p.z > 20.0 && p.z < 36.0 && std::abs(p.x - x) < best)
        best = std::abs(p.x - x), z = p.z;
    return z;
  };
  for (const double groove : {-24.0, -8.0, 8.0, 24.0})
    for (const double beside : {-8.0, 8.0}) EXPECT_GT(underside(groove), underside(groove + beside) + 1.2);
  int rim = 0;
  for (const Point<Part>& p : mesh.vertices)
    rim += p.z == 0.0 && std::abs(std::hypot(std::abs(p.x) - 55.0, p.y) - 15.0) < 1e-4;
  EXPECT_EQ(rim, 2 * 82);
}

}  // namespace
}  // namespace tiltfeed::sim
