// Contours at constant z' against closed forms and against the ball let down on every facet by search.
#include "pathgen/pattern/contours.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <map>
#include <random>
#include <vector>

#include "tests/judges/contour_proof.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

TEST(ZLevel, HemisphereOnAPlaneGivesCirclesOfTheGrownSphere) {
  Shapes shapes;
  shapes.bead(3.0, -2.0, 0.0, 10.0, 0.0, false, 180);
  shapes.floor(-20, -25, 26, 21, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  ContourOptions options = options_for(1.0, 1.0);
  options.height.high = 11.5;
  const Contours contours = contours_of(*field, options);
  ASSERT_EQ(contours.groups.size(), 1u);
  ASSERT_EQ(contours.groups[0].size(), 10u);  // from z' = 11.5 down to 2
  EXPECT_TRUE(contours.warnings.empty());
  double expected = 10.55;
  for (const Pass& pass : contours.groups[0]) {
    EXPECT_TRUE(is_closed(pass));
    EXPECT_NEAR(pass[0].flat.z, expected, 1e-9);
    EXPECT_LT(signed_area(pass), 0.0);  // climb: the dome on the right
    const double r = std::sqrt(144.0 - expected * expected);
    for (const EnvelopePoint& p : pass) {
      EXPECT_NEAR(p.flat.z, expected, 1e-9);
      // The facets lie up to 0.003 inside the sphere; near the top a height of as much is far aside.
      EXPECT_NEAR(radius_about(p, 3.0, -2.0), r, kTolerance + 0.012 * expected / r);
      EXPECT_LT(angle_between(p.normal, p.axis), kPi / 2.0 + 1e-6);
    }
    expected -= 0.95;
  }
  expect_on_the_border(shapes.mesh, *field, contours, 60);
}

TEST(ZLevel, ConventionalRunsTheOtherWayRound) {
  Shapes shapes;
  shapes.bead(0.0, 0.0, 0.0, 6.0, 0.0, false, 60);
  shapes.floor(-15, -15, 15, 15, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  ContourOptions options = options_for(2.0, 1.0);
  options.pattern.climb = false;
  each_pass(contours_of(*field, options), [](const Pass& pass) { EXPECT_GT(signed_area(pass), 0.0); });
}

TEST(ZLevel, ConeGivesCirclesOfItsParallelCone) {
  Shapes shapes;
  const double rise = std::tan(Angle::from_degrees(60.0).radians());
  shapes.revolve(0, 0, {{8.0, 0.0}, {0.0, 8.0 * rise}}, 240);
  shapes.floor(-16, -16, 16, 16, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  const Contours contours = contours_of(*field, options_for(1.5, 1.0));
  std::size_t on_flank = 0;
  each_pass(contours, [&](const Pass& pass) {
    // Where the ball touches the cone's side: r = (apex - z) / tan + R / sin, away from tip and foot.
    const double z = pass[0].flat.z;
    if (z > 8.0 * rise - 1.0 || z < 3.1) return;
    ++on_flank;
    const double r = (8.0 * rise - z) / rise + kBallRadius / std::sin(Angle::from_degrees(60.0).radians());
    for (const EnvelopePoint& p : pass) EXPECT_NEAR(radius_about(p, 0, 0), r, kTolerance);
  });
  EXPECT_GE(on_flank, 6u);
  expect_on_the_border(shapes.mesh, *field, contours, 60);
}

Shapes pocket_with_island() {
  Shapes shapes;
  shapes.floor(-20, -20, 20, 20, 0.0);
  shapes.box(-20, -20, 20, -15, 0.0, 8.0), shapes.box(-20, 15, 20, 20, 0.0, 8.0);
  shapes.box(-20, -15, -15, 15, 0.0, 8.0), shapes.box(15, -15, 20, 15, 0.0, 8.0);
  shapes.box(-3, -4, 5, 2, 0.0, 8.0);
  return shapes;
}

TEST(ZLevel, PocketIsItsOutlineShrunkAndItsIslandGrownByTheBall) {
  const Shapes shapes = pocket_with_island();
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  ContourOptions options = options_for(2.0, 1.0);
  options.height = {kBallRadius, 8.0};
  const Contours contours = contours_of(*field, options);
  double walls = 0.0, islands = 0.0;
  std::vector<double> pocket_levels;
  each_pass(contours, [&](const Pass& pass) {
    ASSERT_TRUE(is_closed(pass));
    const double area = std::abs(signed_area(pass)) / 2.0;
    if (std::abs(pass[0].flat.x) > 16.0 || std::abs(pass[0].flat.y) > 16.0) return;  // round the block
    pocket_levels.push_back(pass[0].flat.z);
    if (signed_area(pass) > 0.0) {
      ++walls;  // sharp corners
      EXPECT_NEAR(area, 26.0 * 26.0, 26.0 * 4.0 * kTolerance);
    } else {
      ++islands;  // corners rounded by the ball
      EXPECT_NEAR(area, 8.0 * 6.0 + 2.0 * kBallRadius * 14.0 + kPi * kBallRadius * kBallRadius,
                  40.0 * kTolerance);
    }
    for (const EnvelopePoint& p : pass) EXPECT_NEAR(angle_between(p.normal, p.axis), kPi / 2.0, 1e-6);
  });
  EXPECT_EQ(walls, 3);
  EXPECT_EQ(islands, 3);
  // Level by level: the island belongs to its pocket.
  EXPECT_TRUE(std::is_sorted(pocket_levels.rbegin(), pocket_levels.rend()));
  expect_on_the_border(shapes.mesh, *field, contours, 80);
}

TEST(ZLevel, AnAcuteCornerIsFollowedToItsEnd) {
  // A pocket between two walls that meet at `corner`, turned so that the grid lines meet it anyhow. The
  // ball's centre comes as near to the corner as R / sin(half of it).
  for (const double corner : {25.0, 60.0})
    for (int turn = 0; turn < 4; ++turn) {
      SCOPED_TRACE(std::to_string(corner) + " degrees, turn " + std::to_string(turn));
      const double half = corner / 2.0 * kPi / 180.0, along = 0.1 + turn * kPi / 2.2, length = 25.0;
      const Place apex{0.37, -0.21};
      const auto at = [&](double side, double z) {
        const double a = along + side * half;
        return Point<Part>{apex.x + length * std::cos(a), apex.y + length * std::sin(a), z};
      };
      Shapes shapes;
      shapes.floor(-40, -40, 40, 40, 0.0);
      const Point<Part> low{apex.x, apex.y, 0.0}, high{apex.x, apex.y, 8.0};
      shapes.quad(at(-1, 0), low, high, at(-1, 8));
      shapes.quad(low, at(1, 0), at(1, 8), high);
      const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
      ContourOptions options = options_for(4.0, 1.7);
      options.height = {4.0, 6.0};
      const Contours contours = contours_of(*field, options);
      const double deep = kBallRadius / std::sin(half);
      const Place end{apex.x + deep * std::cos(along), apex.y + deep * std::sin(along)};
      double nearest = 1e9;
      each_pass(contours, [&](const Pass& pass) {
        for (const EnvelopePoint& p : pass) nearest = std::min(nearest, distance({p.flat.x, p.flat.y}, end));
      });
      EXPECT_LT(nearest, 2.0 * kTolerance / std::sin(half));
      expect_on_the_border(shapes.mesh, *field, contours, 300);
    }
}

/// A steep wall with narrow notches at uneven distances: the ball dips in, wherever on a move that is.
TEST(ZLevel, OverNotchesTheBallKeepsInTouchAllAlong) {
  Shapes shapes;
  std::mt19937 random(11);
  std::vector<std::array<double, 2>> section{{-12.0, 0.0}};
  for (double x = -11.0; x < 11.0; x += 1.3 + 2.0 * (random() * 0x1.0p-32)) {
    section.push_back({x - 0.27, 0.0});
    section.push_back({x, 0.3});
    section.push_back({x + 0.27, 0.0});
  }
  section.push_back({12.0, 0.0});
  for (std::size_t i = 0; i + 1 < section.size(); ++i) {
    const auto at = [&](std::size_t k, double z) {
      return Point<Part>{section[k][0], section[k][1] + 0.05 * z, z};
    };
    shapes.quad(at(i, 0.0), at(i + 1, 0.0), at(i + 1, 6.0), at(i, 6.0));
  }
  shapes.floor(-12, 0.6, 12, 9, 6.0), shapes.floor(-16, -8, 16, 0, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  ContourOptions options = options_for(3.0, 3.0);
  options.height = {kBallRadius + 0.3, 6.0};
  std::size_t places = 0;
  each_pass(contours_of(*field, options), [&](const Pass& pass) {
    for (std::size_t i = 0; i + 1 < pass.size(); ++i)
      for (const double share : {0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9}) {
        const Point<Part> p = lerp(pass[i].centre, pass[i + 1].centre, share);
        if (std::abs(p.x) > 9.0 || p.y > 0.0) continue;
        const auto height = [&](double x, double y) {
          return let_down(shapes.mesh, field->deformation.axis_line(x, y), kBallRadius, p.z - 1.0);
        };
        EXPECT_LE(height(p.x, p.y), p.z + kTolerance);
        EXPECT_GT(height(p.x, p.y + 1.3 * kTolerance), p.z) << p.x << ' ' << p.y << ' ' << p.z;
        ++places;
      }
  });
  EXPECT_GT(places, 200u);
}

TEST(ZLevel, TorusBeadGivesTwoCircles) {
  Shapes shapes;
  shapes.bead(0, 0, 12.0, 3.0, 0.0, true, 240);
  shapes.floor(-22, -22, 22, 22, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  const Contours contours = contours_of(*field, options_for(1.0, 0.8));
  EXPECT_EQ(pass_count(contours), 6u);  // z' = 5 down to 2
  each_pass(contours, [&](const Pass& pass) {
    const double z = pass[0].flat.z, half = std::sqrt(25.0 - z * z);
    const double r = signed_area(pass) < 0.0 ? 12.0 + half : 12.0 - half;
    for (const EnvelopePoint& p : pass) EXPECT_NEAR(radius_about(p, 0, 0), r, kTolerance + 0.006 * z / half);
  });
  expect_on_the_border(shapes.mesh, *field, contours, 60);
}

TEST(ZLevel, EachIslandIsFinishedBeforeTheNextUntilTheyAreOne) {
  // Three rings, one inside the other, and a dome by the side.
  Shapes shapes;
  for (double r : {6.0, 13.0, 20.0}) shapes.bead(0, 0, r, 1.5, 0.0, true, 150);
  shapes.bead(40.0, 0.0, 0.0, 5.0, 0.0, false, 60);
  shapes.floor(-30, -30, 55, 30, 0.0);
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  const Contours contours = contours_of(*field, options_for(0.5, 0.8));
  // By what it goes round, every loop of the rings once a level; levels fall within each.
  std::map<std::pair<int, int>, std::vector<double>> chains;
  std::size_t at = 0, first_dome = 1000, last_dome = 0, domes = 0;
  each_pass(contours, [&](const Pass& pass) {
    const bool dome = pass[0].flat.x > 28.0;
    if (dome) first_dome = std::min(first_dome, at), last_dome = at, ++domes;
    const int ring = dome ? 0 : static_cast<int>(std::lround((radius_about(pass[0], 0, 0) - 6.0) / 7.0)) + 1;
    chains[{ring, signed_area(pass) > 0.0}].push_back(pass[0].flat.z);
    ++at;
  });
  EXPECT_EQ(chains.size(), 7u);
  for (const auto& [what, levels] : chains) {
    EXPECT_TRUE(std::is_sorted(levels.rbegin(), levels.rend())) << what.first << what.second;
    EXPECT_EQ(std::adjacent_find(levels.begin(), levels.end()), levels.end());
    EXPECT_GE(levels.size(), 3u) << what.first << what.second;
  }
  EXPECT_EQ(last_dome - first_dome + 1, domes);  // nothing else in between
}

TEST(ZLevel, AWallMuchThinnerThanTheGridIsNotMissed) {
  // The ball over the ridge: just below its top the wall of the envelope is 0.3 side steps thick.
  Shapes shapes;
  shapes.floor(-20, -20, 20, 20, 0.0);
  const double c = std::cos(0.3), s = std::sin(0.3), w = 0.01;
  const auto corner = [&](double u, double v, double z) {
    return Point<Part>{u * c - v * s, u * s + v * c, z};
  };
  shapes.quad(corner(-9, -w, 5), corner(9, -w, 5), corner(9, w, 5), corner(-9, w, 5));
  shapes.quad(corner(-9, -w, 0), corner(9, -w, 0), corner(9, -w, 5), corner(-9, -w, 5));
  shapes.quad(corner(9, w, 0), corner(-9, w, 0), corner(-9, w, 5), corner(9, w, 5));
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  const double step = 1.3, thick = 0.3 * step;
  ContourOptions options = options_for(20.0, step);
  const double h = std::sqrt(kBallRadius * kBallRadius - std::pow(thick / 2.0 - w, 2));
  options.height = {5.0 + h, 7.0};
  options.pattern.step_down = 2.0;
  const Contours contours = contours_of(*field, options);
  ASSERT_EQ(pass_count(contours), 1u);
  const Pass& pass = contours.groups[0][0];
  ASSERT_TRUE(is_closed(pass));
  double length_round = 0.0;
  for (std::size_t i = 0; i + 1 < pass.size(); ++i)
    length_round += distance(pass[i].centre, pass[i + 1].centre);
  EXPECT_NEAR(length_round, 2.0 * 18.0 + kPi * thick, 0.3);
  expect_on_the_border(shapes.mesh, *field, contours, 60);
}

TEST(ZLevel, InAWindowItIsWhatItIsThereWithoutOne) {
  Shapes shapes = pocket_with_island();
  std::mt19937 random(17);
  const auto draw = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  for (int i = 0; i < 12; ++i) {
    const double x = draw(-12, 12), y = draw(-12, 12);
    shapes.bead(x, y, 0.0, draw(1.0, 4.0), 0.0, false, 24);
  }
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  ContourOptions options = options_for(1.0, 0.5);
  options.height = {2.2, 5.2};  // the same levels, whatever is highest in a window
  std::vector<Contours> all;
  for (const double spacing : {0.5, 0.46, 0.41, 0.34}) {
    options.pattern.side_step = spacing;
    all.push_back(contours_of(*field, options));
  }
  options.pattern.side_step = 0.5;
  std::size_t compared = 0, largest = 0, windows = 0;
  for (int i = 0; i < 40; ++i) {
    const double x = draw(-22, 20), y = draw(-22, 20);
    const FlatBounds window{x, x + draw(0.05, 9.0), y, y + draw(0.05, 9.0)};
    options.window = window;
    const auto some = z_level(*field, options, {});
    if (!some) {
      EXPECT_NE(some.error().message.find("no surface"), std::string::npos) << some.error().message;
      continue;
    }
    // Levels begin at what is highest, which may be lower there.
    double first = 0.0;
    each_pass(*some, [&](const Pass& pass) { first = std::max(first, pass[0].flat.z); });
    if (std::abs(first - 4.2) > 1e-9) continue;
    ++windows;
    compared += expect_same_in(window, *some, all);
    std::size_t here = 0;
    each_pass(*some, [&](const Pass& pass) { here += pass.size(); });
    largest = std::max(largest, here);
  }
  EXPECT_GT(windows, 8u);
  EXPECT_GT(compared, 1000u);
  std::size_t of_all = 0;
  each_pass(all[0], [&](const Pass& pass) { of_all += pass.size(); });
  EXPECT_LT(largest, of_all / 2) << "nothing is saved";
}

TEST(ZLevel, IsTheSameForAnyNumberOfThreads) {
  const Shapes shapes = pocket_with_island();
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  const auto with = [&](std::size_t threads) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return contours_of(*field, options_for(3.0, 1.0));
  };
  const Contours one = with(1), two = with(2);
  ASSERT_EQ(one.groups.size(), two.groups.size());
  for (std::size_t g = 0; g < one.groups.size(); ++g) {
    ASSERT_EQ(one.groups[g].size(), two.groups[g].size());
    for (std::size_t p = 0; p < one.groups[g].size(); ++p) {
      ASSERT_EQ(one.groups[g][p].size(), two.groups[g][p].size());
      for (std::size_t i = 0; i < one.groups[g][p].size(); ++i)
        EXPECT_EQ(one.groups[g][p][i].centre, two.groups[g][p][i].centre);
    }
  }
}

TEST(ZLevel, RefusesTooManyLevelsAndNothing) {
  const Shapes shapes = pocket_with_island();
  const auto field = field_over(shapes.mesh, {}, 2.0 * kBallRadius);
  auto result = z_level(*field, options_for(1e-5, 1.0), {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::kLimit);
  ContourOptions above = options_for(1.0, 1.0);
  above.boundary = {{100, 100}, {110, 100}, {105, 110}};
  result = z_level(*field, above, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::kUnreachable);
  result = z_level(*field, options_for(1.0, 1.0), [](const char*, double) { return false; });
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::kCancelled);
}

}  // namespace
}  // namespace tiltfeed
