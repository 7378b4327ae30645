#pragma once
// Contours at constant z' of a field, and what they are held to: the ball let down on every facet by search.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pathgen/pattern/contours.h"
#include "tests/shapes/contour_shapes.h"

namespace tiltfeed {
using namespace pathgen;

inline constexpr double kTolerance = 0.01;  ///< of a path; the envelope has a quarter

inline ContourOptions options_for(double step_down, double side_step) {
  ContourOptions options;
  options.envelope = {kTolerance / 2.0, 0.03};  // (Z3): the border is at most twice that aside
  options.pattern.kind = PatternKind::kZLevel;
  options.pattern.step_down = step_down, options.pattern.side_step = side_step;
  options.height.low = kBallRadius;  // the floor; past its rim the surface falls on
  return options;
}

inline Contours contours_of(const ClField& field, const ContourOptions& options) {
  auto result = z_level(field, options, {});
  EXPECT_TRUE(result) << result.error().message;
  return result ? *result : Contours{};
}

inline double radius_about(const EnvelopePoint& p, double x, double y) {
  return std::hypot(p.centre.x - x, p.centre.y - y);
}

/// Twice the area of a closed pass in the flat plane; positive: counter-clockwise seen from the tool.
inline double signed_area(const Pass& pass) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < pass.size(); ++i)
    sum += pass[i].flat.x * pass[i + 1].flat.y - pass[i + 1].flat.x * pass[i].flat.y;
  return sum;
}

inline std::size_t pass_count(const Contours& contours) {
  std::size_t count = 0;
  for (const auto& group : contours.groups) count += group.size();
  return count;
}

template <class Visit>
void each_pass(const Contours& contours, Visit visit) {
  for (const auto& group : contours.groups)
    for (const Pass& pass : group) visit(pass);
}

/// A point of every few, and the middle of the move after it.
template <class Visit>
void each_place(const Contours& contours, const Deformation& map, std::size_t most, Visit visit) {
  std::size_t all = 0;
  each_pass(contours, [&](const Pass& pass) { all += pass.size(); });
  const std::size_t every = 1 + all / most;
  std::size_t k = 0;
  each_pass(contours, [&](const Pass& pass) {
    for (std::size_t i = 0; i + 1 < pass.size(); ++i) {
      if (k++ % every != 0) continue;
      visit(pass[i].flat);
      visit(map.flatten(lerp(pass[i].centre, pass[i + 1].centre, 0.37)));
    }
  });
}

/// Nowhere does the ball cut deeper than the tolerance, and everywhere it touches within it.
inline void expect_on_the_border(const Mesh& mesh, const ClField& field, const Contours& contours,
                                 std::size_t most) {
  const Deformation& map = field.deformation;
  std::size_t places = 0;
  each_place(contours, map, most, [&](Point<Flat> p) {
    ++places;
    const auto height = [&](double x, double y) {
      return let_down(mesh, map.axis_line(x, y), kBallRadius, p.z - 2.0 * kTolerance);
    };
    ASSERT_LE(height(p.x, p.y), p.z + kTolerance) << p.x << ' ' << p.y << ' ' << p.z;
    double beside = height(p.x, p.y);
    for (int k = 0; k < 16 && beside <= p.z; ++k)
      beside = std::max(beside, height(p.x + kTolerance * std::cos(k * kPi / 8.0),
                                       p.y + kTolerance * std::sin(k * kPi / 8.0)));
    EXPECT_GT(beside, p.z) << p.x << ' ' << p.y << ' ' << p.z;
  });
  EXPECT_GT(places, 20u);
}

inline bool in_bounds(const FlatBounds& b, Point<Flat> f) {
  return f.x >= b.min_x && f.x <= b.max_x && f.y >= b.min_y && f.y <= b.max_y;
}

/// How far a point is off the passes at its level, mm.
inline double off_passes(const EnvelopePoint& p, const Contours& contours) {
  double nearest = 1e9;
  each_pass(contours, [&](const Pass& pass) {
    if (std::abs(pass[0].flat.z - p.flat.z) > 1e-9) return;
    for (std::size_t i = 0; i + 1 < pass.size(); ++i) {
      const Vec3 along = pass[i + 1].centre - pass[i].centre, to = p.centre - pass[i].centre;
      const double share = std::clamp(dot(to, along) / std::max(dot(along, along), 1e-30), 0.0, 1.0);
      nearest = std::min(nearest, length(to - along * share));
    }
  });
  return nearest;
}

/// In the window `some` are what is found without one. `all`: on grids of several spacings, each of which may
/// miss what is narrower than its spacing. What all of them have must be there; what none of them has must
/// not. How many points were compared.
inline std::size_t expect_same_in(const FlatBounds& window, const Contours& some,
                                  const std::vector<Contours>& all) {
  const double same = 3.0 * kTolerance;
  std::size_t count = 0;
  const auto each_point = [&](const Contours& contours, const auto& visit) {
    each_pass(contours, [&](const Pass& pass) {
      for (const EnvelopePoint& p : pass)
        if (in_bounds(window, p.flat)) visit(p);
    });
  };
  each_point(some, [&](const EnvelopePoint& p) {
    double off = 1e9;
    for (const Contours& one : all) off = std::min(off, off_passes(p, one));
    EXPECT_LE(off, same) << p.flat.x << ' ' << p.flat.y << ' ' << p.flat.z;
    ++count;
  });
  each_point(all[0], [&](const EnvelopePoint& p) {
    for (const Contours& one : all)
      if (off_passes(p, one) > same) return;
    EXPECT_LE(off_passes(p, some), same) << p.flat.x << ' ' << p.flat.y << ' ' << p.flat.z;
    ++count;
  });
  return count;
}

}  // namespace tiltfeed
