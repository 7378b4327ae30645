// Box trees against all pairs of facets by another way to the distance, and against closed forms.

#include "sim/collision/body_tree.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/shapes/collision_shop.h"

namespace tiltfeed::sim {
namespace {

BodyTree tree_of(const SolidMesh& mesh) {
  BodyTree tree;
  tree.add(mesh.vertices, mesh.facets);
  tree.build();
  return tree;
}

struct Dice {
  std::mt19937_64 random;
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  Vec3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
  Placement placement(double size) {
    return {rotation_about(normalized(vector(1.0)), (*this)(-kPi, kPi)), vector(size)};
  }
  SolidMesh soup(std::uint32_t facets) {
    SolidMesh mesh;
    for (std::uint32_t i = 0; i < facets; ++i) {
      const Vec3 at = vector(20.0);
      for (int k = 0; k < 3; ++k) mesh.vertices.push_back(at + vector(3.0));
      mesh.facets.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
  }
};

TEST(BodyTree, TellsTheDistanceOfRandomFacets) {
  Dice dice{std::mt19937_64(21)};
  int apart = 0;
  for (int i = 0; i < 60; ++i) {
    const SolidMesh a = dice.soup(30), b = dice.soup(25);
    const Placement pose = dice.placement(i % 2 == 0 ? 40.0 : 70.0);
    SolidMesh moved = b;
    moved.place(pose.rotation, pose.shift);
    const double least = brute_distance(facets_of(a), facets_of(moved));
    const BodyTree one = tree_of(a), other = tree_of(b);
    const auto nearest = one.nearest(other, pose, 1000.0);
    ASSERT_TRUE(nearest);
    EXPECT_NEAR(nearest->distance, least, 1e-6) << "case " << i;
    const Corners p = facets_of(a)[nearest->a], q = facets_of(moved)[nearest->b];
    EXPECT_NEAR(brute_distance(p, q), least, 1e-6) << "case " << i;
    EXPECT_TRUE(one.nearer(other, pose, least + 1e-5)) << "case " << i;
    if (least < 1e-3) continue;
    ++apart;
    EXPECT_FALSE(one.nearer(other, pose, least - 1e-5)) << "case " << i;
  }
  EXPECT_GT(apart, 20);
}

TEST(BodyTree, KnowsBoxesAndCylinders) {
  const BodyTree box = tree_of(block_mesh({20, 20, 10})),
                 rod = tree_of(round_mesh({{4.0, 0.0}, {4.0, 30.0}}));
  // Beside each other, above each other, edge to side.
  EXPECT_NEAR(box.nearest(box, {{}, {27, 3, 2}}, 100.0)->distance, 7.0, 1e-12);
  EXPECT_NEAR(box.nearest(box, {{}, {23, 24, 0}}, 100.0)->distance, 5.0, 1e-12);
  EXPECT_NEAR(box.nearest(rod, {{}, {0, 0, 12.5}}, 100.0)->distance, 2.5, 1e-12);
  const Placement lying{rotation_about({1, 0, 0}, kPi / 2.0), {0, 15, 17}};
  EXPECT_NEAR(box.nearest(rod, lying, 100.0)->distance, 3.0, kSagitta);
  EXPECT_EQ(box.nearest(rod, {{}, {0, 0, 5}}, 100.0)->distance, 0.0);
  EXPECT_FALSE(box.nearer(box, {{}, {27, 3, 2}}, 6.999));
}

TEST(BodyTree, KnowsWhatIsInside) {
  SolidMesh two = block_mesh({20, 20, 20});
  const BodyTree one = tree_of(two);
  EXPECT_EQ(one.shells().size(), 1u);
  EXPECT_NEAR(one.distance({0, 0, 5}), 5.0, 1e-12);
  Dice dice{std::mt19937_64(4)};
  const BodyTree rod = tree_of(round_mesh({{4.0, 0.0}, {7.0, 30.0}}));
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = dice.vector(25.0);
    EXPECT_EQ(one.in_box(p) && one.inside(p),
              std::max(std::abs(p.x), std::abs(p.y)) < 10 && p.z > 0 && p.z < 20);
    const double radius = 4.0 + p.z * 0.1, off = std::hypot(p.x, p.y);
    if (std::abs(off - radius) < 2 * kSagitta) continue;
    EXPECT_EQ(rod.in_box(p) && rod.inside(p), p.z > 0 && off < radius) << p.x << " " << p.y << " " << p.z;
  }
  SolidMesh apart = two;
  apart.place({}, {100, 0, 0});
  BodyTree both;
  both.add(two.vertices, two.facets), both.add(apart.vertices, apart.facets);
  both.build();
  EXPECT_EQ(both.shells().size(), 2u);
}

TEST(SolidMesh, RoundBodiesAreWithinTheirSagitta) {
  for (const double radius : {0.5, 4.0, 60.0, 400.0}) {
    const SolidMesh rod = round_mesh({{radius, 0.0}, {radius, 10.0}});
    EXPECT_LE(rod.sagitta, kSagitta + 0.02 * (radius < 1.0));
    double least = kInfinity;
    for (const auto& [a, b, c] : rod.facets) {
      const Vec3 middle = (rod.vertices[a] + rod.vertices[b]) * 0.5;
      if (rod.vertices[a].z == rod.vertices[b].z && rod.vertices[c].z != rod.vertices[a].z)
        least = std::min(least, std::hypot(middle.x, middle.y));
    }
    EXPECT_NEAR(radius - least, rod.sagitta, 1e-9);
  }
}

}  // namespace
}  // namespace tiltfeed::sim
