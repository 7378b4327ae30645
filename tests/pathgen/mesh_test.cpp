#include "pathgen/mesh/mesh.h"
#include "pathgen/mesh/mesh_check.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using namespace soup;
using enum DefectKind;

TEST(Mesh, SoundCube) {
  Soup soup = cube(0, 2);
  for (std::size_t i = 0; i < soup.size(); i += 2)  // -0 and 0 weld
    for (Point<Part>& p : soup[i]) p = {p.x == 0.0 ? -0.0 : p.x, p.y == 0.0 ? -0.0 : p.y, p.z};
  const CheckedMesh mesh = check(soup);
  EXPECT_EQ(mesh.mesh.vertices.size(), 8U);
  EXPECT_EQ(mesh.mesh.facets.size(), 12U);
  EXPECT_EQ(mesh.sides, Sides::kOutward);
  EXPECT_TRUE(mesh.defects.empty());
  EXPECT_TRUE(mesh.warnings.empty());
  EXPECT_DOUBLE_EQ(mesh.volume, 8.0);
  EXPECT_EQ(mesh.bounds.min, (Point<Part>{0, 0, 0}));
  EXPECT_EQ(mesh.bounds.max, (Point<Part>{2, 2, 2}));
  for (std::uint32_t i = 0; i < 12; ++i) EXPECT_EQ(mesh.mesh.source[i], i);
  EXPECT_EQ(canonical(corners_of(mesh.mesh)), canonical(soup));
  EXPECT_EQ(mesh.mesh.facets[0], (std::array<std::uint32_t, 3>{0, 1, 2}));  // numbered by first use
}

// (mesh.h, properties 1, 2 and 4)
TEST(Mesh, DefectsAreCountedByHand) {
  const Soup sound = cube(0, 2);
  const auto without = [](Soup s, std::size_t i) { return s.erase(s.begin() + i), s; };
  const auto turned = [](Soup s, std::size_t i) { return s[i] = reversed(s[i]), s; };
  const Corners flat = {{{0, 0, 0}, {0, 2, 0}, {0, 1, 0}}};       // on an edge of the cube
  const Corners collapsed = {{{0, 0, 0}, {0, 0, 0}, {9, 9, 9}}};  // 9, 9, 9 is used nowhere else
  // Facet 2 (top) split in the middle of its edge (0,0,2)-(2,0,2), its neighbour below not.
  Soup junction = without(sound, 2);
  junction.push_back({{{0, 0, 2}, {1, 0, 2}, {2, 2, 2}}});
  junction.push_back({{{1, 0, 2}, {2, 0, 2}, {2, 2, 2}}});
  // The edge's facets 6 and 8 belong to the first cube, those between to the second.
  Soup woven = turned(sound, 0);
  const Soup second = box({2, 2, 0}, {4, 4, 2});
  woven.insert(woven.begin() + 8, second.begin(), second.end());
  const Corners seam = {{{0, 0, 2}, {2, 0, 2}, {1, 0, 2}}};
  const struct {
    const char* name;
    Soup soup;
    std::size_t facets, vertices;
    Sides sides;
    Counts counts;
    double volume;
    const char* first;  ///< place of the first defect
  } cases[] = {
      {"facet missing",
       without(sound, 0),
       12,
       8,
       Sides::kOutward,
       {{kOpenEdge, 3}, {kFilled, 1}},
       8.0,
       "facet 0 at (1, 1, 0)"},
      {"two facets missing",
       without(without(sound, 0), 0),
       10,
       8,
       Sides::kBoth,
       {{kOpenEdge, 4}},
       NAN,
       "facet 2 at (1, 0, 0)"},
      {"facet turned",
       turned(sound, 5),
       12,
       8,
       Sides::kOutward,
       {{kMisoriented, 3}, {kFlipped, 1}},
       8.0,
       nullptr},
      {"duplicate",
       sound + Soup{sound[4]},
       12,
       8,
       Sides::kOutward,
       {{kDuplicate, 1}},
       8.0,
       "facet 12 at (0, 0, 0)"},
      {"reversed duplicates",
       sound + Soup{reversed(sound[4]), reversed(sound[7])},
       12,
       8,
       Sides::kOutward,
       {{kDuplicate, 2}},
       8.0,
       "facet 12 at (0, 0, 0)"},
      {"without area",
       Soup{collapsed, flat} + sound,
       12,
       8,
       Sides::kOutward,
       {{kDegenerate, 2}},
       8.0,
       "facet 0 at (0, 0, 0)"},
      {"T-junction",
       junction,
       14,
       9,
       Sides::kOutward,
       {{kOpenEdge, 3}, {kSplit, 1}},
       8.0,
       "facet 4 at (1, 0, 2)"},
      {"T-junction seamed",
       junction + Soup{seam},
       13,
       9,
       Sides::kOutward,
       {{kDegenerate, 1}},
       8.0,
       "facet 13 at (0, 0, 2)"},
      {"T-junction seamed behind a facet without area",
       Soup{flat} + junction + Soup{seam},
       13,
       9,
       Sides::kOutward,
       {{kDegenerate, 2}},
       8.0,
       "facet 0 at (0, 0, 0)"},
      {"T-junction seamed the wrong way",
       Soup{reversed(seam)} + junction,
       13,
       9,
       Sides::kOutward,
       {{kDegenerate, 1}, {kMisoriented, 3}, {kFlipped, 1}},
       8.0,
       "facet 0 at (0, 0, 2)"},
      {"two cubes on one edge",
       sound + box({2, 2, 0}, {4, 4, 2}),
       24,
       16,
       Sides::kOutward,
       {{kNonManifold, 1}, {kSeparated, 1}},
       16.0,
       nullptr},
      {"two cubes on one edge, the first facet turned",
       woven,
       24,
       16,
       Sides::kOutward,
       {{kNonManifold, 1}, {kMisoriented, 3}, {kFlipped, 1}, {kSeparated, 1}},
       16.0,
       nullptr},
      {"two cubes on one vertex", sound + cube(2, 4), 24, 15, Sides::kOutward, {}, 16.0, nullptr},
      {"hollow", sound + reversed(cube(0.5, 1.5)), 24, 16, Sides::kOutward, {}, 7.0, nullptr},
      {"inside out", reversed(sound), 12, 8, Sides::kOutward, {{kInsideOut, 1}}, 8.0, "facet 0 at (0, 0, 0)"},
      {"hollow inside out",
       reversed(sound) + cube(0.5, 1.5),
       24,
       16,
       Sides::kOutward,
       {{kInsideOut, 2}},
       7.0,
       "facet 0 at (0, 0, 0)"},
      {"solid in solid", sound + cube(0.5, 1.5), 24, 16, Sides::kOutward, {}, 9.0, nullptr},
      {"one of two inside out",
       sound + reversed(cube(3, 4)),
       24,
       16,
       Sides::kOutward,
       {{kInsideOut, 1}},
       9.0,
       "facet 12 at (3, 3, 3)"},
      {"void in the arm", ell() + reversed(cube(0.5, 1.5)), 32, 20, Sides::kOutward, {}, 119.0, nullptr},
      {"solid in the notch inside out",
       ell() + reversed(cube(3, 5)),
       32,
       20,
       Sides::kOutward,
       {{kInsideOut, 1}},
       128.0,
       nullptr},
      {"solid across the notch inside out",
       ell() + reversed(cube(1, 4)),
       32,
       20,
       Sides::kOutward,
       {{kInsideOut, 1}},
       147.0,
       nullptr},
      {"void in a solid in a void",
       cube(0, 8) + reversed(cube(1, 7)) + cube(2, 6) + reversed(cube(3, 5)),
       48,
       32,
       Sides::kOutward,
       {},
       512.0 - 216 + 64 - 8,
       nullptr},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const CheckedMesh mesh = check(c.soup);
    EXPECT_EQ(mesh.mesh.facets.size(), c.facets);
    EXPECT_EQ(mesh.mesh.source.size(), c.facets);
    EXPECT_EQ(mesh.mesh.vertices.size(), c.vertices);
    EXPECT_EQ(mesh.sides, c.sides);
    EXPECT_EQ(counts(mesh), c.counts);
    if (!std::isnan(c.volume)) {
      EXPECT_NEAR(mesh.volume, c.volume, 1e-12);
    }
    EXPECT_EQ(mesh.warnings.size(), mesh.defects.size());
    for (std::size_t i = 0; i < mesh.warnings.size(); ++i) {
      EXPECT_EQ(mesh.warnings[i].find(std::to_string(mesh.defects[i].count) + " "), 0U) << mesh.warnings[i];
      EXPECT_NE(mesh.warnings[i].find(mesh.defects[i].first), std::string::npos) << mesh.warnings[i];
    }
    if (c.first != nullptr) {
      EXPECT_EQ(mesh.defects.at(0).first, c.first);
    }
    if (mesh.mesh.facets.size() != c.soup.size() - counts(mesh)[kDegenerate] - counts(mesh)[kDuplicate])
      continue;                                                  // cut up or filled
    for (std::size_t i = 0; i < mesh.mesh.facets.size(); ++i) {  // no corner moves
      const Corners& f = c.soup[mesh.mesh.source[i]];
      const Triangle now = canonical(corners_of(mesh.mesh)[i]);
      EXPECT_TRUE(now == canonical(f) || now == canonical(reversed(f)));
    }
  }
}

/// What repair makes of a soup whose mesh without it is `bare`: the same defects found; closed or as it was.
bool agrees_after_repair(const Soup& soup, const CheckedMesh& bare) {
  const CheckedMesh mesh = check(soup);
  Counts found = counts(mesh), before = counts(bare);
  for (DefectKind kind : {kFlipped, kInsideOut}) found.erase(kind), before.erase(kind);
  for (DefectKind kind : {kWelded, kSplit, kFlap, kSeparated, kFilled}) found.erase(kind);
  EXPECT_EQ(found, before);
  if (mesh.sides == bare.sides) {
    EXPECT_EQ(mesh.mesh.facets, bare.mesh.facets);
    EXPECT_EQ(mesh.mesh.vertices, bare.mesh.vertices);
    return false;
  }
  EXPECT_EQ(mesh.sides, Sides::kOutward);
  EXPECT_GT(mesh.volume, 0.0);
  for (const auto& [ends, senses] : edges_of(corners_of(mesh.mesh))) {  // touching solids share an edge
    EXPECT_EQ(std::count(senses.begin(), senses.end(), 1), std::count(senses.begin(), senses.end(), -1));
  }
  return true;
}

/// Random damage; what check_mesh says against brute force over the same soup.
// (mesh.h, property 1; mesh_check.h, property 1)
TEST(Mesh, AgreesWithBruteForce) {
  std::mt19937 random(11);
  const auto below = [&random](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  int outward = 0, repaired = 0;
  for (int round = 0; round < 600; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    Soup soup = round % 2 ? torus() : cube(0, 2) + ell() + reversed(cube(0.5, 1.5));
    std::set<Triple> points;
    for (const Corners& f : soup)
      for (const Point<Part>& p : f) points.insert(triple(p));
    const std::vector<Triple> pool(points.begin(), points.end());
    for (std::size_t edits = below(4); edits > 0; --edits) {
      const std::size_t at = below(soup.size());
      const auto random_point = [&] {
        const Triple t = pool[below(pool.size())];
        return Point<Part>{t[0], t[1], t[2]};
      };
      switch (below(5)) {
        case 0:
          soup.erase(soup.begin() + at);
          break;
        case 1:
          soup[at] = reversed(soup[at]);
          break;
        case 2:
          soup.push_back({soup[at][1], soup[at][2], soup[at][0]});
          break;
        case 3:
          soup.push_back(reversed(soup[at]));
          break;
        case 4:
          soup.push_back({random_point(), random_point(), random_point()});
          break;
      }
    }
    std::shuffle(soup.begin(), soup.end(), random);

    Soup kept;  // by brute force: no facet without area, none twice
    std::set<std::set<Triple>> seen;
    std::uint64_t degenerate = 0, duplicate = 0;
    for (const Corners& f : soup) {
      const std::set<Triple> corners{triple(f[0]), triple(f[1]), triple(f[2])};
      const bool repeated = corners.size() == 3 && !seen.insert(corners).second;
      const bool flat = length(cross(f[1] - f[0], f[2] - f[0])) < 1e-9;
      if (!repeated && !flat) kept.push_back(f);
      duplicate += repeated;
      degenerate += flat && !repeated;
    }
    Counts expected = edge_defects(kept);
    const Result<CheckedMesh> bare = check_mesh(stl_of(soup), {.distance = 0.0});
    ASSERT_TRUE(bare);
    const CheckedMesh& mesh = *bare;
    Counts found = counts(mesh);
    if (degenerate > 0) expected[kDegenerate] = degenerate;
    if (duplicate > 0) expected[kDuplicate] = duplicate;
    const Soup result = corners_of(mesh.mesh);
    found.erase(kFlipped), found.erase(kInsideOut);
    EXPECT_EQ(found, expected);
    EXPECT_EQ(result.size(), kept.size());
    EXPECT_EQ(mesh.sides == Sides::kOutward, is_closed(result));
    repaired += agrees_after_repair(soup, mesh);
    if (counts(mesh).contains(kFlipped)) {
      EXPECT_FALSE(edge_defects(result).contains(kMisoriented));
    }
    if (mesh.sides == Sides::kOutward) {
      EXPECT_GT(mesh.volume, 0.0);
      ++outward;
    }
  }
  EXPECT_GT(outward, 150);
  EXPECT_LT(outward, 450);
  EXPECT_GT(repaired, 50);
}

TEST(Mesh, OrderAndPlaceDoNotMatter) {
  std::mt19937 random(5);
  Soup soup = torus() + ell() + reversed(cube(0.5, 1.5));
  soup.erase(soup.begin() + 7);
  soup[30] = reversed(soup[30]);
  const CheckedMesh first = check(soup);
  for (int round = 0; round < 20; ++round) {
    Soup other = soup;
    std::shuffle(other.begin(), other.end(), random);
    for (Corners& f : other) {
      std::rotate(f.begin(), f.begin() + round % 3, f.end());
      for (Point<Part>& p : f) p = p + Vec3{512.0 * round, -64, 0.25};
    }
    const CheckedMesh mesh = check(other);
    EXPECT_EQ(counts(mesh), counts(first));
    EXPECT_EQ(mesh.sides, first.sides);
    EXPECT_EQ(mesh.mesh.vertices.size(), first.mesh.vertices.size());
  }
  const CheckedMesh again = check(soup);
  EXPECT_EQ(again.mesh.facets, first.mesh.facets);
  EXPECT_EQ(again.mesh.vertices, first.mesh.vertices);
  EXPECT_EQ(again.warnings, first.warnings);
}

TEST(Mesh, RefusesWhatCannotBePlanned) {
  const auto message = [](const Soup& soup) {
    const Result<CheckedMesh> mesh = check_mesh(stl_of(soup));
    if (mesh) return std::string("accepted");
    EXPECT_EQ(mesh.error().code, Code::kMesh);
    return mesh.error().message;
  };
  EXPECT_NE(message({}).find("nothing is left to plan"), std::string::npos);
  EXPECT_NE(message({{{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, {{{0, 0, 0}, {5, 0, 0}, {5, 0, 0}}}})
                .find("nothing is left to plan: all 2 facets are without area"),
            std::string::npos);
  // A pair of facets without area on the same corners seams nothing but itself.
  EXPECT_NE(message({{{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}}, {{{1, 1, 1}, {0, 0, 0}, {2, 2, 2}}}})
                .find("nothing is left to plan"),
            std::string::npos);
  EXPECT_NE(message(cube(0, 10'001)).find("beyond the limit of 10000 mm"), std::string::npos);
  Soup nan = cube(0, 2);
  nan[7][1].z = NAN;
  EXPECT_NE(message(nan).find("facet 7 has a corner at (0, 2, nan) mm"), std::string::npos) << message(nan);
}

TEST(Mesh, SmallPartsAskForTheUnit) {
  const CheckedMesh mesh = check(cube(0, 0.0625));
  EXPECT_EQ(mesh.sides, Sides::kOutward);
  ASSERT_EQ(mesh.warnings.size(), 1U);
  EXPECT_NE(mesh.warnings[0].find("only (0.0625, 0.0625, 0.0625) mm large: check the unit"),
            std::string::npos);
}

}  // namespace
}  // namespace tiltfeed
