// Rows, contours and roughing of random parts, cutters and axes, each held against the part by brute force:
// no gouge, contact within the tolerance, rapids clear. What it draws is fixed; a case that fails names its
// number.
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "tests/judges/path_proof.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

using Facets = std::vector<std::array<Point<Part>, 3>>;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double in(double low, double high) { return low + (high - low) * (random_() * 0x1.0p-32); }
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  bool chance(double p) { return in(0.0, 1.0) < p; }

 private:
  std::mt19937 random_;
};

void quad(Facets& f, Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
  f.push_back({a, b, c}), f.push_back({a, c, d});
}

/// About its own origin, z up: a prism of a polygon, its upper end larger or smaller.
Facets prism(Draw& draw, int sides, double radius, double low, double high, double taper) {
  std::vector<double> radii;
  for (int k = 0; k < sides; ++k) radii.push_back(radius * draw.in(0.6, 1.0));
  const auto at = [&](int k, bool up) {
    const double turn = 2.0 * kPi * (k % sides) / sides;
    const double r = radii[static_cast<std::size_t>(k % sides)] * (up ? taper : 1.0);
    return Point<Part>{r * std::cos(turn), r * std::sin(turn), up ? high : low};
  };
  Facets f;
  for (int k = 0; k < sides; ++k) {
    quad(f, at(k, false), at(k + 1, false), at(k + 1, true), at(k, true));
    f.push_back({at(k, true), at(k + 1, true), {0, 0, high}});
    f.push_back({at(k + 1, false), at(k, false), {0, 0, low}});
  }
  return f;
}

/// A block with a rugged top, in steps or not.
Facets terrain(Draw& draw, double half, int n, double rise, bool steps) {
  std::vector<double> lines, heights;
  for (int i = 0; i <= n; ++i)
    lines.push_back(-half + 2.0 * half * (i + (i > 0 && i < n ? draw.in(-0.4, 0.4) : 0.0)) / n);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double h = draw.in(0.0, rise);
      heights.push_back(steps ? 3.0 * std::round(h / 3.0) : h);
    }
  const auto at = [&](int i, int j, bool top) {
    return Point<Part>{lines[static_cast<std::size_t>(i)], lines[static_cast<std::size_t>(j)],
                       top ? heights[static_cast<std::size_t>(i * (n + 1) + j)] : -4.0};
  };
  Facets f;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      quad(f, at(i, j, true), at(i + 1, j, true), at(i + 1, j + 1, true), at(i, j + 1, true));
      quad(f, at(i, j, false), at(i, j + 1, false), at(i + 1, j + 1, false), at(i + 1, j, false));
    }
    quad(f, at(i, 0, false), at(i + 1, 0, false), at(i + 1, 0, true), at(i, 0, true));
    quad(f, at(n, i, false), at(n, i + 1, false), at(n, i + 1, true), at(n, i, true));
    quad(f, at(i + 1, n, false), at(i, n, false), at(i, n, true), at(i + 1, n, true));
    quad(f, at(0, i + 1, false), at(0, i, false), at(0, i, true), at(0, i + 1, true));
  }
  return f;
}

/// What two angles give, as a closed surface: wound round and round.
template <class At>
Facets wound(int m, int n, At at) {
  Facets f;
  const auto corner = [&](int i, int j) { return at(2.0 * kPi * (i % m) / m, j % n); };
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j)
      quad(f, corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
  return f;
}

/// A rugged ring round x; what the tool sees from the axis or from outside is rugged alike.
Facets ring(Draw& draw, double inner, double outer, double half, int around) {
  const std::array<std::array<double, 2>, 6> section{
      {{-half, outer}, {0, outer}, {half, outer}, {half, inner}, {0, inner}, {-half, inner}}};
  std::vector<double> noise;
  for (int i = 0; i < around * 6; ++i) noise.push_back(draw.in(-1.5, 1.5));
  return wound(around, 6, [&](double turn, int j) {
    const auto i = static_cast<std::size_t>(std::lround(turn * around / (2.0 * kPi)));
    const double r = section[static_cast<std::size_t>(j)][1] + noise[i * 6 + static_cast<std::size_t>(j)];
    return Point<Part>{section[static_cast<std::size_t>(j)][0], r * std::cos(turn), r * std::sin(turn)};
  });
}

struct Case {
  PlanOptions options;
  CheckedMesh part;
  bool contact = true;  ///< must the cutter touch all along?
};

Facets shape_of(Draw& draw, const AxisFrame& axis, bool& round) {
  round = axis.mode == AxisMode::kLine && draw.chance(0.4);
  if (round) {
    const double inner = draw.in(12.0, 20.0);
    return ring(draw, inner, inner + draw.in(5.0, 9.0), draw.in(5.0, 12.0), 6 + draw.below(18));
  }
  switch (draw.below(3)) {
    case 0:
      return prism(draw, 3 + draw.below(8), draw.in(5.0, 10.0), -draw.in(2.0, 6.0), draw.in(2.0, 8.0),
                   draw.chance(0.5) ? 1.0 : draw.in(0.3, 1.5));
    case 1:
      return terrain(draw, draw.in(5.0, 10.0), 2 + draw.below(5), draw.in(2.0, 11.0), draw.chance(0.4));
    default: {
      Facets plate = terrain(draw, 9.0, 1, 0.0, false);
      Facets spike = prism(draw, 4, draw.in(0.3, 3.0), 1.0, 3.0 + draw.in(2.0, 12.0), draw.in(0.05, 1.0));
      plate.insert(plate.end(), spike.begin(), spike.end());
      return plate;
    }
  }
}

Cutter cutter_of(Draw& draw) {
  Cutter c{draw.in(1.5, 5.0), 60.0, draw.chance(0.5) ? 40.0 : draw.in(10.0, 25.0)};
  c.type = static_cast<CutterType>(draw.below(4));
  if (c.type == CutterType::kBullNose) c.corner_radius = c.diameter * draw.in(0.05, 0.45);
  if (c.type == CutterType::kTaperBall) c.taper = Angle::from_degrees(draw.in(1.0, 20.0));
  return c;
}

Result<Case> make_case(PatternKind kind, unsigned seed) {
  Draw draw(seed * 8u + static_cast<unsigned>(kind));
  Case c;
  PlanOptions& o = c.options;
  o.axis = {static_cast<AxisMode>(draw.below(4)),
            draw.chance(0.5) ? Sense::kOutward : Sense::kInward,
            {7, -3, 11},
            {0.8, 0.6, 0},
            {-0.36, 0.48, 0.8},
            0.0};
  if (o.axis.mode == AxisMode::kCircle) o.axis.circle_radius = draw.in(14.0, 40.0);
  const bool inside = o.axis.sense == Sense::kInward && o.axis.mode != AxisMode::kFixed;
  bool round = false;
  Stl stl;
  stl.facets = shape_of(draw, o.axis, round);
  const double turn = draw.in(0.0, 2.0 * kPi), side = draw.chance(0.3) ? draw.in(-6.0, 6.0) : 0.0;
  double off = o.axis.mode == AxisMode::kFixed ? 0.0
               : draw.chance(0.3)              ? draw.in(0.0, 14.0)
                                               : draw.in(14.0, 40.0);
  if (o.axis.mode == AxisMode::kCircle)
    off = o.axis.circle_radius + draw.in(-0.8, 1.3) * o.axis.circle_radius;
  const Vec3 b = cross(o.axis.n, o.axis.t);
  for (auto& facet : stl.facets)
    for (Point<Part>& p : facet) {
      Vec3 v{p.x, p.y, p.z};
      if (!round) {
        v = {p.x * std::cos(turn) - p.y * std::sin(turn) + side, p.x * std::sin(turn) + p.y * std::cos(turn),
             p.z};
        if (inside) v.y = -v.y, v.z = -v.z;
        v.z += off;
      }
      p = o.axis.origin + o.axis.t * v.x + b * v.y + o.axis.n * v.z;
    }
  auto part = check_mesh(stl);
  if (!part) return tl::unexpected(part.error());
  c.part = std::move(*part);
  o.cutter = cutter_of(draw);
  // A long cone touches everything from everywhere: too slow for a test of contours.
  if (kind == PatternKind::kZLevel && o.cutter.type == CutterType::kTaperBall)
    o.cutter.type = CutterType::kBall;
  o.tolerance = draw.chance(0.7) ? 0.01 : 0.002;
  o.pattern.kind = kind;
  o.pattern.along = draw.chance(0.5) ? Along::kX : Along::kY;
  if (kind == PatternKind::kRaster && draw.chance(0.4))
    o.pattern.angle = Angle::from_degrees(draw.in(-89.0, 89.0));
  if (kind == PatternKind::kRaster && draw.chance(0.4)) o.pattern.measure = StepMeasure::kSurface;
  o.pattern.side_step = draw.in(0.9, 3.0), o.pattern.step_down = draw.in(0.7, 3.0);
  o.pattern.direction = draw.chance(0.5) ? Direction::kZigzag : Direction::kOneWay;
  o.pattern.climb = draw.chance(0.5);
  o.links.clearance = draw.in(1.5, 4.0), o.links.approach = draw.in(0.1, 1.4);
  if (kind != PatternKind::kRough && draw.chance(0.5)) o.links.join_distance = draw.in(1.0, 8.0);
  if (draw.chance(0.4)) o.links.lead_radius = draw.in(0.3, 3.0);
  o.cut_feed = Feed::from_mm_per_min(1000), o.plunge_feed = Feed::from_mm_per_min(300);
  c.contact = kind != PatternKind::kRough;
  return c;
}

std::string name_of(const testing::TestParamInfo<PatternKind>& of) {
  if (of.param == PatternKind::kZLevel) return "contours";
  return of.param == PatternKind::kRaster ? "raster" : "rough";
}

/// The first ones, and those that a longer search has found wrong before.
std::vector<unsigned> cases_of(PatternKind kind) {
  std::vector<unsigned> all(kind == PatternKind::kRaster ? 80 : kind == PatternKind::kZLevel ? 60 : 20);
  std::iota(all.begin(), all.end(), 0u);
  if (kind == PatternKind::kRaster) all.insert(all.end(), {431, 787, 832, 839});
  return all;
}

class RandomPath : public testing::TestWithParam<PatternKind> {};

TEST_P(RandomPath, NeitherGougesNorLeavesThePart) {
  const std::vector<unsigned> cases = cases_of(GetParam());
  unsigned planned = 0;
  for (const unsigned seed : cases) {
    SCOPED_TRACE("case " + std::to_string(seed));
    const auto made = make_case(GetParam(), seed);
    if (!made) continue;  // a spike that stands in the plate
    const PlanOptions& o = made->options;
    const auto found = plan(made->part, o, {});
    if (!found) {  // said why: the axis feature inside the part, or nothing that faces the tool
      EXPECT_FALSE(found.error().message.empty());
      continue;
    }
    ++planned;
    const std::size_t stride = 1 + found->path.moves.size() / 3000;
    const Measured m = PathProof(o.axis, o.pattern.along, o.cutter, o.tolerance, made->part, found->path)
                           .measure(3000, stride);
    EXPECT_LE(m.gouge, o.tolerance) << pasteable(m.gouge_at);
    EXPECT_LE(m.rapid_overlap, o.tolerance) << pasteable(m.rapid_at);
    if (made->contact) {
      EXPECT_LE(m.contact, o.tolerance * 1.0001) << pasteable(m.contact_at);
    }
  }
  EXPECT_GT(planned, cases.size() / 2);
}

INSTANTIATE_TEST_SUITE_P(Patterns, RandomPath,
                         testing::Values(PatternKind::kRaster, PatternKind::kZLevel, PatternKind::kRough),
                         name_of);

}  // namespace
}  // namespace tiltfeed
