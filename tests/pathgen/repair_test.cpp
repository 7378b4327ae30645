#include "pathgen/mesh/repair.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <algorithm>
#include <set>

#include "pathgen/mesh/mesh_check.h"
#include "sim/parts/parts.h"
#include "tests/shapes/damage.h"
#include "tests/shapes/welded.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using namespace soup;
using namespace damage;
using enum DefectKind;

/// What must hold of any repaired mesh, against the soup it was made from.
void expect_sound(const CheckedMesh& mesh, const Soup& broken) {
  EXPECT_EQ(mesh.sides, Sides::kOutward) << (mesh.warnings.empty() ? "" : mesh.warnings[0]);
  const Soup after = corners_of(mesh.mesh);
  EXPECT_NEAR(mesh.volume, volume_of(after), 1e-9 * std::abs(mesh.volume) + 1e-9);
  EXPECT_GT(mesh.volume, 0.0);
  EXPECT_TRUE(std::is_sorted(mesh.mesh.source.begin(), mesh.mesh.source.end()));
  for (std::uint32_t s : mesh.mesh.source) ASSERT_LT(s, broken.size());
  std::set<Triple> corners;
  for (const Corners& f : broken)
    for (const Point<Part>& p : f) corners.insert(triple(p));
  for (const Point<Part>& p : mesh.mesh.vertices) EXPECT_TRUE(corners.contains(triple(p)));  // no new points
}

struct Shape {
  const char* name;
  Soup soup;
};
std::vector<Shape> shapes() {
  return {{"sphere", sim::hollow_sphere()}, {"handle", sim::handle()}, {"torus", torus()}};
}

// (mesh.h, property 3; mesh_check.h, property 2)
TEST(Repair, DamagedFormulaPartsComeBackWithinTheDistance) {
  Random random(2024);
  for (const auto& [name, sound] : shapes()) {
    for (int round = 0; round < 4; ++round) {
      SCOPED_TRACE(name + (", round " + std::to_string(round)));
      const double jitter = kDistance / 2 / (2 * std::sqrt(3.0)) * (round + 1) / 4;  // copies stay in reach
      Soup broken = sound;
      crack(broken, jitter, random);
      turn_some(broken, 5 * round, random);
      repeat_some(broken, 10 * round, random);
      const CheckedMesh mesh = check(broken);
      expect_sound(mesh, broken);
      EXPECT_EQ(mesh.mesh.facets.size(), sound.size());
      const Soup after = corners_of(mesh.mesh);
      EXPECT_TRUE(is_closed(after));
      const double apart = jitter * std::sqrt(3.0) + kDistance / 2;
      EXPECT_LT(hausdorff(after, sound), apart);
      EXPECT_NEAR(mesh.volume, volume_of(sound), area_of(sound) * apart);
      EXPECT_GT(counts(mesh).at(kWelded), sound.size());
      for (std::size_t i = 0; i < after.size(); ++i) {  // each corner near one of the facet it came from
        const Corners& from = broken[mesh.mesh.source[i]];
        for (const Point<Part>& p : after[i])
          EXPECT_LE(std::min({distance(p, from[0]), distance(p, from[1]), distance(p, from[2])}),
                    kDistance / 2);
      }
    }
  }
}

// (mesh.h, property 3)
TEST(Repair, MissingFacetsAreFilledAsTheyWere) {
  Random random(7);
  for (const auto& [name, sound] : shapes()) {
    for (std::size_t missing : {1, 3, 6}) {
      SCOPED_TRACE(name + (", missing " + std::to_string(missing)));
      Soup broken = sound;
      remove_some(broken, missing, random);
      const CheckedMesh mesh = check(broken);
      expect_sound(mesh, broken);
      EXPECT_EQ(counts(mesh), (Counts{{kOpenEdge, 3 * missing}, {kFilled, missing}}));
      EXPECT_EQ(canonical(corners_of(mesh.mesh)), canonical(sound));  // a hole of three edges has one fill
      EXPECT_NEAR(mesh.volume, volume_of(sound), 1e-9 * volume_of(sound));
      const Soup after = corners_of(mesh.mesh);
      for (std::size_t i = 0; i < after.size(); ++i) {  // sources: itself, or a facet beside it
        int shared = 0;
        for (const Point<Part>& p : after[i])
          for (const Point<Part>& q : broken[mesh.mesh.source[i]]) shared += p == q;
        EXPECT_GE(shared, 2);
      }
    }
  }
}

/// A cube of 4 mm with squares of 1 mm, two facets each.
Soup block() {
  Soup s;
  const auto at = [](double x, double y, double z) { return Point<Part>{x, y, z}; };
  for (int i = 0; i < 16; ++i) {
    const double u = i / 4, v = i % 4;
    add_quad(s, at(u, v, 4), at(u + 1, v, 4), at(u + 1, v + 1, 4), at(u, v + 1, 4));
    add_quad(s, at(u, v, 0), at(u, v + 1, 0), at(u + 1, v + 1, 0), at(u + 1, v, 0));
    add_quad(s, at(u, 0, v), at(u + 1, 0, v), at(u + 1, 0, v + 1), at(u, 0, v + 1));
    add_quad(s, at(u, 4, v), at(u, 4, v + 1), at(u + 1, 4, v + 1), at(u + 1, 4, v));
    add_quad(s, at(0, u, v), at(0, u, v + 1), at(0, u + 1, v + 1), at(0, u + 1, v));
    add_quad(s, at(4, u, v), at(4, u + 1, v), at(4, u + 1, v + 1), at(4, u, v + 1));
  }
  return s;
}
int shared_corners(const Corners& a, const Corners& b) {
  int shared = 0;
  for (const Point<Part>& p : a)
    for (const Point<Part>& q : b) shared += p == q;
  return shared;
}

TEST(Repair, TwoMissingNeighboursAreFilledTheWayTheSurfaceGoesOn) {
  const Soup sound = block();
  ASSERT_TRUE(is_closed(sound));
  int pairs = 0;
  for (std::size_t i = 0; i < sound.size(); ++i) {
    for (std::size_t j = i + 1; j < sound.size(); ++j) {
      if (shared_corners(sound[i], sound[j]) != 2) continue;
      Soup holed = sound;
      holed.erase(holed.begin() + static_cast<std::ptrdiff_t>(j));
      holed.erase(holed.begin() + static_cast<std::ptrdiff_t>(i));
      const CheckedMesh mesh = check(holed);  // across an edge of the block too
      EXPECT_EQ(counts(mesh), (Counts{{kOpenEdge, 4}, {kFilled, 1}})) << i << ", " << j << mesh.warnings[0];
      EXPECT_NEAR(mesh.volume, 64.0, 1e-12);
      ++pairs;
    }
  }
  EXPECT_EQ(pairs, 288);  // each edge of 192 facets
}

TEST(Repair, JunctionsAreCutIntoTheNeighbour) {
  Random random(99);
  for (const auto& [name, sound] : shapes()) {
    for (double off : {0.0, kDistance / 2.01}) {
      SCOPED_TRACE(name + (", off " + std::to_string(off)));
      Soup broken = sound;
      cut_some(broken, 20, off, random);
      const CheckedMesh mesh = check(broken);
      expect_sound(mesh, broken);
      EXPECT_GT(counts(mesh)[kSplit], 0U);
      EXPECT_FALSE(counts(mesh).contains(kFilled));
      const Soup after = corners_of(mesh.mesh);
      EXPECT_TRUE(is_closed(after));
      EXPECT_LE(hausdorff(after, sound), off + 1e-12);
      EXPECT_NEAR(mesh.volume, volume_of(sound), area_of(sound) * (off + 1e-12));
      EXPECT_EQ(sim::count_crossings(after, 2.0), sim::count_crossings(sound, 2.0));
    }
  }
}

TEST(Repair, EverythingAtOnce) {
  Random random(31);
  for (const auto& [name, sound] : shapes()) {
    SCOPED_TRACE(name);
    Soup broken = sound;
    const std::size_t missing = remove_some(broken, 3, random);
    const double jitter = 1e-4;
    crack(broken, jitter, random);
    turn_some(broken, 10, random);
    repeat_some(broken, 12, random);
    std::shuffle(broken.begin(), broken.end(), random);
    const CheckedMesh mesh = check(broken);
    expect_sound(mesh, broken);
    EXPECT_EQ(counts(mesh)[kFilled], missing);
    EXPECT_EQ(counts(mesh)[kDuplicate], 12U);
    EXPECT_GT(counts(mesh)[kFlipped], 0U);
    EXPECT_LT(hausdorff(corners_of(mesh.mesh), sound), jitter * std::sqrt(3.0) + kDistance / 2);
  }
}

TEST(Repair, TouchingSolidsAreSeparated) {
  const Soup pair = cube(0, 2) + box({2, 2, 0}, {4, 4, 2});
  Soup three = pair + box({2, 0, 2}, {4, 2, 4});  // touches both along an edge, in a common corner
  const struct {
    Soup soup;
    std::uint64_t edges;
    double volume;
    std::size_t vertices;
  } cases[] = {{pair, 1, 16, 16}, {reversed(pair), 1, 16, 16}, {three, 3, 24, 24}};
  for (const auto& c : cases) {
    const CheckedMesh mesh = check(c.soup);
    EXPECT_EQ(mesh.sides, Sides::kOutward) << mesh.warnings[0];
    EXPECT_EQ(counts(mesh)[kSeparated], c.edges);
    EXPECT_NEAR(mesh.volume, c.volume, 1e-12);
    EXPECT_EQ(mesh.mesh.vertices.size(), c.vertices);
    EXPECT_EQ(mesh.mesh.facets.size(), c.soup.size());
    EXPECT_EQ(mesh.warnings.size(), mesh.defects.size());
  }
}

TEST(Repair, SliversOnAnEdgeAreDropped) {
  const auto with_flap = [](double height) {
    return cube(0, 2) + Soup{{{{2, 0, 2}, {2, 2, 2}, {2 + height, 1, 2 + height}}}};
  };
  const CheckedMesh mesh = check(with_flap(kDistance / 4));
  EXPECT_EQ(mesh.sides, Sides::kOutward);
  EXPECT_EQ(canonical(corners_of(mesh.mesh)).size(), mesh.mesh.facets.size());
  EXPECT_NEAR(mesh.volume, 8.0, area_of(cube(0, 2)) * kDistance);
  EXPECT_LE(hausdorff(corners_of(mesh.mesh), with_flap(kDistance / 4)), kDistance);
}

TEST(Repair, SameForAnyNumberOfThreads) {
  Random random(8);
  Soup broken = sim::handle();
  remove_some(broken, 3, random);
  cut_some(broken, 20, 0.0, random);
  turn_some(broken, 3, random);
  repeat_some(broken, 9, random);
  std::vector<CheckedMesh> all;
  for (std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    for (const Soup& soup : {broken, sim::handle()}) all.push_back(check(soup));
  }
  for (std::size_t i = 2; i < all.size(); ++i) {
    EXPECT_EQ(all[i].mesh.vertices, all[i % 2].mesh.vertices);
    EXPECT_EQ(all[i].mesh.facets, all[i % 2].mesh.facets);
    EXPECT_EQ(all[i].mesh.source, all[i % 2].mesh.source);
    EXPECT_EQ(all[i].warnings, all[i % 2].warnings);
    EXPECT_EQ(all[i].volume, all[i % 2].volume);
  }
  EXPECT_EQ(all[0].sides, Sides::kOutward);
}

TEST(Repair, CornersAreNumberedByFirstUse) {
  Random random(12);
  Soup soup = sim::cooling_pin();
  std::shuffle(soup.begin(), soup.end(), random);  // each corner comes again all over the file
  const sim::Welded brute = sim::weld(soup);       // an ordered map of corners
  for (int round = 0; round < 5; ++round) {
    const CheckedMesh mesh = check(soup);
    EXPECT_EQ(mesh.sides, Sides::kOutward);
    EXPECT_EQ(mesh.mesh.vertices, brute.vertices);
    for (std::size_t i = 0; i < brute.facets.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_EQ(mesh.mesh.facets[i][k], static_cast<std::uint32_t>(brute.facets[i][k]));
  }
}

/// A part that needs a repair shows how far its check is, and hears the user.
TEST(Repair, TheCheckCountsItsShare) {
  Stl stl;
  stl.facets = soup::cube(0, 10);
  stl.facets.pop_back();
  std::vector<double> shares;
  const auto check = [&](std::size_t most) {
    shares.clear();
    return check_mesh(stl, {0.01}, [&](double share) {
      shares.push_back(share);
      return shares.size() < most;
    });
  };
  ASSERT_TRUE(check(100));
  const std::set<double> steps(shares.begin(), shares.end());
  EXPECT_GE(steps.size(), 7u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_LE(shares.back(), 1.0);
  const std::size_t all = shares.size();
  for (std::size_t most = 1; most < all; ++most) {
    const auto stopped = check(most);
    ASSERT_FALSE(stopped) << most;
    EXPECT_EQ(stopped.error().code, Code::kCancelled);
  }
}

}  // namespace
}  // namespace tiltfeed
