// The links between passes, held against brute force on random parts with holes: nothing touches the part,
// joins and leads keep off the envelope's under side, the tilt limit holds on the way; and every fallback.
#include "pathgen/linking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <set>

#include "path_proof.h"
#include "pathgen/joins.h"
#include "pathgen/leads.h"
#include "pathgen/link_order.h"
#include "pathgen/nearest_ends.h"
#include "pathgen/raster.h"
#include "pathgen/travel.h"

namespace tiltfeed {
namespace {

constexpr double kTolerance = 0.01, kRadius = 2.0, kClearance = 6.0;

const AxisFrame kFixedFrame{AxisMode::kFixed, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};

/// A sheet of cells over the flat space, wound round the axis feature; `height` gives z' of a corner,
/// `there` whether a cell is. Open, so both sides count.
template <class Height, class There>
CheckedMesh sheet(const AxisFrame& frame, double rho, Point<Flat> low, Point<Flat> high, int columns,
                  int rows, Height height, There there) {
  CheckedMesh part;
  const Deformation map(frame, rho);
  for (int i = 0; i <= columns; ++i)
    for (int j = 0; j <= rows; ++j) {
      Point<Flat> f{low.x + (high.x - low.x) * i / columns, low.y + (high.y - low.y) * j / rows, 0.0};
      f.z = height(f.x, f.y);
      part.mesh.vertices.push_back(map.unflatten(f));
    }
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(i * (rows + 1) + j); };
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      if (!there(i, j)) continue;
      part.mesh.facets.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      part.mesh.facets.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) part.mesh.source.push_back(f);
  part.sides = Sides::kBoth;
  const Point<Part> first = part.mesh.vertices.front();
  part.bounds.min = part.bounds.max = first;
  for (const Point<Part> v : part.mesh.vertices) {
    part.bounds.min = {std::min(part.bounds.min.x, v.x), std::min(part.bounds.min.y, v.y), std::min(part.bounds.min.z, v.z)};
    part.bounds.max = {std::max(part.bounds.max.x, v.x), std::max(part.bounds.max.y, v.y), std::max(part.bounds.max.z, v.z)};
  }
  return part;
}

/// Everything that link() asks for, made the planner's way.
struct Shop {
  CheckedMesh part;
  PlanOptions options;
  Linking links;
  std::unique_ptr<const ClField> field;
  EnvelopeOptions limits{kTolerance / 4.0, 0.025};
  std::vector<std::vector<Pass>> slices;
  std::unique_ptr<FarSide> far_side;
  std::unique_ptr<Envelope> envelope;

  Shop(CheckedMesh made, const AxisFrame& frame, double side_step, double shank = 30.0,
       const std::function<bool(const EnvelopePoint&)>& unwanted = {}, Vec3 up = {0, 0, 1},
       double tilt_max = 180.0)
      : part(std::move(made)) {
    options.cutter = {2.0 * kRadius, 100.0, shank};
    options.axis = frame;
    options.tolerance = kTolerance;
    options.pattern.side_step = side_step;
    std::vector<std::string> warnings;
    auto found = make_field(part, options, warnings);
    if (!found) throw std::runtime_error(found.error().message);
    field = std::move(*found);
    envelope = std::make_unique<Envelope>(field->surface, field->deformation, field->index, limits);
    links.tilt_max = Angle::from_degrees(tilt_max), links.up = up;
    double top = -1e9;
    const auto lines = raster_lines(field->index, options.pattern);
    for (const FlatLine& line : *lines) {
      std::vector<Pass> passes = envelope->along(line).passes;
      for (const Pass& pass : passes)
        for (const EnvelopePoint& p : pass) top = std::max(top, p.flat.z);
      leave_out(passes, [&](const EnvelopePoint& p) {
        return (unwanted && unwanted(p)) || angle_between(p.axis, up) > links.tilt_max.radians();
      });
      slices.emplace_back();
      for (const Pass& pass : passes)
        slices.back().push_back(thinned(pass, limits.tolerance, limits.max_axis_step));
    }
    if (field->deformation.s() > 0.0)
      for (const Point<Part> v : part.mesh.vertices)
        top = std::max(top, field->deformation.flatten(v).z + kRadius);
    links.reference_height = kRadius;
    links.clearance_z = top + kClearance;
    links.clearance = kClearance;
    links.approach = 1.0;
    links.thinning = limits.tolerance;
    links.plunge_ratio = 3.0;
    far_side = std::make_unique<FarSide>(part.mesh, field->deformation, options, links.clearance_z);
    far_side->trim(slices);
  }

  Linked run() { return link(slices, *field, links, *far_side, *envelope); }
  Travel travel() { return {field->deformation, links, *far_side}; }
  std::size_t passes() const {
    std::size_t count = 0;
    for (const auto& slice : slices) count += slice.size();
    return count;
  }
};

Measured proof(const Shop& shop, const Linked& linked) {
  ToolPath path;
  path.moves = linked.moves;
  const PathProof proof(shop.options.axis, Along::kX, shop.options.cutter, kTolerance, shop.part, path);
  return proof.measure(4 * linked.moves.size());
}

void expect_proven(const Shop& shop, const Linked& linked) {
  const Measured m = proof(shop, linked);
  EXPECT_LE(m.gouge, kTolerance) << pasteable(m.gouge_at);
  EXPECT_LE(m.contact, kTolerance) << pasteable(m.contact_at);
  EXPECT_LE(m.rapid_overlap, kTolerance / 2.0) << pasteable(m.rapid_at);
}

/// Length of the tip's way over all that does not cut.
double air_of(const Linked& linked) {
  double air = 0.0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i)
    if (linked.moves[i].kind != MoveKind::kCut)
      air += distance(linked.moves[i - 1].pose.tip, linked.moves[i].pose.tip);
  return air;
}

/// How often a rapid is followed by something else.
std::size_t descents(const Linked& linked) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i)
    count += linked.moves[i - 1].kind == MoveKind::kRapid && linked.moves[i].kind != MoveKind::kRapid;
  return count;
}

[[maybe_unused]] double widest_tilt(const Linked& linked, Vec3 up) {
  double widest = 0.0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i)
    for (double f : {0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0})
      widest = std::max(widest, angle_between(slerp(linked.moves[i - 1].pose.axis,
                                                    linked.moves[i].pose.axis, f), up));
  return widest;
}

struct Feature {
  const char* name;
  AxisFrame frame;
  double rho;
  Point<Flat> low, high;
};

std::vector<Feature> features() {
  const Vec3 t = normalized(Vec3{0.2, 0.9, -0.3}), n = normalized(cross(t, Vec3{0.5, -0.2, 0.8}));
  const Point<Part> o{5.0, -8.0, 3.0};
  return {{"fixed", {AxisMode::kFixed, Sense::kOutward, o, t, n, 0.0}, 0.0, {-25, -20, 0}, {25, 20, 0}},
          {"point", {AxisMode::kPoint, Sense::kOutward, o, t, n, 0.0}, 25.0, {-60, -25, 0}, {60, 25, 0}},
          {"line", {AxisMode::kLine, Sense::kOutward, o, t, n, 0.0}, 20.0, {-20, -55, 0}, {20, 55, 0}},
          {"circle", {AxisMode::kCircle, Sense::kOutward, o, t, n, 60.0}, 14.0, {-90, -25, 0}, {90, 25, 0}},
          {"cavity", {AxisMode::kPoint, Sense::kInward, o, t, n, 0.0}, 40.0, {-70, -40, 0}, {70, 40, 0}}};
}

/// Bumps and holes.
CheckedMesh random_part(const Feature& c, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uniform_int_distribution<int> odd(0, 9);
  const double s = c.frame.sense == Sense::kInward ? -1.0 : 1.0;
  return sheet(
      c.frame, std::max(c.rho, 1.0), c.low, c.high, 18, 12,
      [&](double, double) { return s * c.rho + 0.9 * unit(random); },
      [&](int i, int j) { return odd(random) > 1 && !(i > 6 && i < 11 && j > 3 && j < 9); });
}

class RandomPart : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(RandomPart, JoinsLeadsAndRapidsKeepOffIt) {
  const Feature c = features()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  SCOPED_TRACE(c.name);
  Shop shop(random_part(c, 17u + static_cast<unsigned>(std::get<1>(GetParam()))), c.frame, 2.5,
            c.frame.sense == Sense::kInward ? 20.0 : 30.0);
  shop.links.direction = std::get<1>(GetParam()) % 2 == 0 ? Direction::kZigzag : Direction::kOneWay;
  const bool zigzag = shop.links.direction == Direction::kZigzag;
  const Linked regions = shop.run();
  shop.links.order = PassOrder::kGiven;
  const Linked given = shop.run();
  EXPECT_LE(air_of(regions), air_of(given));
  EXPECT_EQ(given.retracts, shop.passes() - given.skipped_passes);
  EXPECT_EQ(given.joins + given.leads + given.straight_ends, 0u);

  shop.links.order = PassOrder::kRegions;
  shop.links.join_distance = 6.0;
  const Linked joined = shop.run();
  EXPECT_EQ(joined.retracts + joined.joins, shop.passes() - joined.skipped_passes);
  EXPECT_EQ(joined.retracts, descents(joined));
  if (zigzag) {
    EXPECT_LT(joined.retracts, 0.8 * static_cast<double>(given.retracts));
  }

  EXPECT_LE(air_of(joined), air_of(regions) * (1.0 + 1e-12));
  EXPECT_NEAR(joined.air_length, air_of(joined), 1e-9 * air_of(joined));
  expect_proven(shop, joined);

  shop.links.lead_radius = 1.5;
  const Linked led = shop.run();
  EXPECT_EQ(led.leads + led.straight_ends, 2 * led.retracts);
  expect_proven(shop, led);
  std::printf("%-7s %-7s passes %zu: air given %.0f regions %.0f joined %.0f mm; retracts %zu -> %zu; leads %zu of %zu\n",
              c.name, zigzag ? "zigzag" : "one way", shop.passes(), given.air_length, regions.air_length,
              joined.air_length, static_cast<std::size_t>(given.retracts),
              static_cast<std::size_t>(joined.retracts), static_cast<std::size_t>(led.leads),
              static_cast<std::size_t>(led.leads + led.straight_ends));
}

/// Only what lies this far (mm) inside the sheet's border is cut, so that passes end on the surface.
constexpr double kFrame = 5.0;

TEST_P(RandomPart, InsideAFrameLeadsAreTangentialAndStayAbove) {
  const Feature c = features()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  SCOPED_TRACE(c.name);
  const auto outside = [&](const EnvelopePoint& p) {
    const Point<Flat> f = p.flat;
    return f.x < c.low.x + kFrame || f.x > c.high.x - kFrame || f.y < c.low.y + kFrame ||
           f.y > c.high.y - kFrame;
  };
  Shop shop(random_part(c, 40u + static_cast<unsigned>(std::get<1>(GetParam()))), c.frame, 2.5, 25.0, outside);
  shop.links.direction = std::get<1>(GetParam()) % 2 == 0 ? Direction::kZigzag : Direction::kOneWay;
  shop.links.lead_radius = 1.5;
  shop.links.join_distance = 4.0;
  int asked = 0;
  shop.links.allowed = [&](const EnvelopePoint& p) { return ++asked, !outside(p); };
  const Linked linked = shop.run();
  EXPECT_EQ(asked > 0, linked.joins > 0);
  EXPECT_GT(linked.leads, linked.retracts / 3);
  expect_proven(shop, linked);
  const Deformation& map = shop.field->deformation;
  const auto reference = [](const Pose& p) { return p.tip + p.axis * kRadius; };
  std::size_t arcs = 0;
  for (std::size_t i = 8; i + 8 < linked.moves.size(); ++i) {
    const auto kind = [&](std::size_t k) { return linked.moves[k].kind; };
    const auto step = [&](std::size_t k) {
      return reference(linked.moves[k].pose) - reference(linked.moves[k - 1].pose);
    };
    if (kind(i) == MoveKind::kCut) {
      EnvelopePoint p;
      p.flat = map.flatten(reference(linked.moves[i].pose));
      EXPECT_FALSE(outside(p));
    }
    const bool in = kind(i - 1) == MoveKind::kPlunge && kind(i - 2) == MoveKind::kPlunge &&
                    kind(i) == MoveKind::kCut;
    const bool out = kind(i) == MoveKind::kPlunge && kind(i - 1) == MoveKind::kCut;
    if (!in && !out) continue;
    ++arcs;
    // The two chords at the touching point turn by half a step of the arc: a quarter circle and the slope's
    // 45 degrees in 8 moves at the most.
    EXPECT_LT(angle_between(step(i - 1), step(i)), 0.75 * kPi / 8.0 / 2.0 + 1e-6);
    // The arc's other end points along the axis, but for half a step and the axis's own turn.
    std::size_t end = i;
    if (in)
      for (end = i - 1; kind(end - 1) == MoveKind::kPlunge;) --end;
    else
      while (kind(end + 1) == MoveKind::kPlunge) ++end;
    const Vec3 last = in ? -step(end + 1) : step(end), axis = linked.moves[in ? i - 1 : i - 1].pose.axis;
    EXPECT_LT(angle_between(last, axis), 0.75 * kPi / 8.0 / 2.0 + 1e-6);
    EXPECT_EQ(kind(in ? end - 1 : end + 1), MoveKind::kRapid);
  }
  EXPECT_GT(arcs, linked.leads / 2);
  std::printf("%-7s leads %zu of %zu, joins %zu\n", c.name, static_cast<std::size_t>(linked.leads),
              static_cast<std::size_t>(linked.leads + linked.straight_ends),
              static_cast<std::size_t>(linked.joins));
}

INSTANTIATE_TEST_SUITE_P(Modes, RandomPart, testing::Combine(testing::Range(0, 5), testing::Range(0, 2)));

}  // namespace
}  // namespace tiltfeed
