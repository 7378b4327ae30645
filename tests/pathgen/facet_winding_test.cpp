#include "pathgen/mesh/facet_winding.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using namespace soup;
using enum DefectKind;

TEST(Orient, MoebiusStripStaysAsItIs) {
  for (int n : {5, 8, 31}) {
    for (std::size_t turn : {0, 4}) {
      Soup soup = moebius(n);
      soup[turn] = reversed(soup[turn]);
      const Counts before = edge_defects(soup);
      const CheckedMesh mesh = check(soup);
      EXPECT_EQ(mesh.sides, Sides::kBoth);
      EXPECT_EQ(counts(mesh), before);
      EXPECT_EQ(counts(mesh)[kOpenEdge], 2U * n);
      EXPECT_EQ(canonical(corners_of(mesh.mesh)), canonical(soup));
    }
  }
}

TEST(Orient, TurnedFacetsAreRestored) {
  std::mt19937 random(3);
  const Soup sound = torus();
  const double volume = check(sound).volume;
  ASSERT_TRUE(is_closed(sound));
  ASSERT_GT(volume, 0.0);
  for (std::size_t turned = 1; turned <= sound.size(); turned += 1 + turned / 4) {
    std::vector<std::size_t> order(sound.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    Soup soup = sound;
    for (std::size_t k = 0; k < turned; ++k) soup[order[k]] = reversed(soup[order[k]]);
    const Counts before = edge_defects(soup);
    const CheckedMesh mesh = check(soup);
    SCOPED_TRACE(turned);
    EXPECT_EQ(mesh.sides, Sides::kOutward);
    EXPECT_EQ(canonical(corners_of(mesh.mesh)), canonical(sound));
    EXPECT_DOUBLE_EQ(mesh.volume, volume);
    Counts found = counts(mesh);
    EXPECT_EQ(found[kMisoriented], before.contains(kMisoriented) ? before.at(kMisoriented) : 0U);
    EXPECT_EQ(found[kFlipped], std::min(turned, sound.size() - turned));
    if (2 * turned != sound.size()) {
      EXPECT_EQ(found[kInsideOut], 2 * turned > sound.size() ? 1U : 0U);
    }
  }
}

TEST(Orient, TooManyShellsToTellAreTakenOnBothSides) {
  Soup soup = reversed(cube(-2, -1));
  for (int i = 0; i < 10'000; ++i) {
    const double x = 2.0 * (i % 100), y = 2.0 * (i / 100);
    soup = std::move(soup) + box({x, y, 0}, {x + 1, y + 1, 1});
  }
  const CheckedMesh mesh = check(soup);
  EXPECT_EQ(mesh.sides, Sides::kBoth);
  EXPECT_TRUE(mesh.defects.empty());
  ASSERT_EQ(mesh.warnings.size(), 1U);
  EXPECT_NE(mesh.warnings[0].find("10001 closed shells"), std::string::npos) << mesh.warnings[0];
}

}  // namespace
}  // namespace tiltfeed
