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
    part.bounds.min = {std::min(part.bounds.min.x, v.x), std::min(part.bounds.min.y, v.y),
                       std::min(part.bounds.min.z, v.z)};
    part.bounds.max = {std::max(part.bounds.max.x, v.x), std::max(part.bounds.max.y, v.y),
                       std::max(part.bounds.max.z, v.z)};
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
       double tilt_max = 180.0, Along along = Along::kX)
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
    for (const FlatLine& line : lines(along, side_step)) {
      std::vector<Pass> passes = envelope->along(line).passes;
      for (const Pass& pass : passes)
        for (const EnvelopePoint& p : pass) top = std::max(top, p.flat.z);
      leave_out(passes, [&](const EnvelopePoint& p) {
        return (unwanted && unwanted(p)) || angle_between(p.axis, up) > links.tilt_max.radians();
      });
      slices.emplace_back();
      for (const Pass& pass : passes) slices.back().push_back(thinned(pass, limits.tolerance, limits));
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

  /// Straight lines side by side over the part.
  std::vector<FlatLine> lines(Along along, double step) const {
    const FlatBounds& b = field->index.bounds();
    const double x = b.max_x - b.min_x, y = b.max_y - b.min_y;
    std::vector<FlatLine> found;
    for (double at = step / 2.0; at < (along == Along::kX ? y : x); at += step)
      found.push_back(along == Along::kX ? FlatLine{b.min_x, b.min_y + at, 1.0, 0.0, x}
                                         : FlatLine{b.min_x + at, b.min_y, 0.0, 1.0, y});
    return found;
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

double widest_tilt(const Linked& linked, Vec3 up) {
  double widest = 0.0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i) {
    if (linked.moves[i].kind == MoveKind::kCut) continue;
    for (double f : {0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0})
      widest = std::max(
          widest, angle_between(slerp(linked.moves[i - 1].pose.axis, linked.moves[i].pose.axis, f), up));
  }
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
  std::printf(
      "%-7s %-7s passes %zu: air given %.0f regions %.0f joined %.0f mm; retracts %zu -> %zu; leads %zu of "
      "%zu\n",
      c.name, zigzag ? "zigzag" : "one way", shop.passes(), given.air_length, regions.air_length,
      joined.air_length, static_cast<std::size_t>(given.retracts), static_cast<std::size_t>(joined.retracts),
      static_cast<std::size_t>(led.leads), static_cast<std::size_t>(led.leads + led.straight_ends));
}

TEST_P(RandomPart, WithoutJoinsAndLeadsEachPassStandsBetweenTwoLegsOfItsAxes) {
  const Feature c = features()[static_cast<std::size_t>(std::get<0>(GetParam()))];
  SCOPED_TRACE(c.name);
  Shop shop(random_part(c, 3), c.frame, 2.5, 20.0);
  const bool zigzag = std::get<1>(GetParam()) == 0;
  shop.links.direction = zigzag ? Direction::kZigzag : Direction::kOneWay;
  shop.links.order = PassOrder::kGiven;
  const std::vector<Move> moves = shop.run().moves;
  std::size_t at = 0;
  // The tip, `up` over the pass's end along its axis, or on the clearance surface.
  const auto over = [&](const EnvelopePoint& p, double up) {
    return p.centre + p.axis * (std::min(up, shop.links.clearance_z - p.flat.z) - kRadius);
  };
  const auto take = [&](Point<Part> tip, Vec3 axis, MoveKind kind) {
    ASSERT_LT(at, moves.size());
    EXPECT_EQ(moves[at].kind, kind) << at;
    EXPECT_LT(distance(moves[at].pose.tip, tip), 1e-9) << at;
    EXPECT_LT(length(moves[at++].pose.axis - axis), 1e-12);
  };
  bool reversed = false;
  for (std::vector<Pass> slice : shop.slices) {
    if (slice.empty()) continue;
    if (reversed) std::reverse(slice.begin(), slice.end());
    for (Pass& pass : slice) {
      if (reversed) std::reverse(pass.begin(), pass.end());
      const EnvelopePoint &first = pass.front(), &last = pass.back();
      while (at < moves.size() && distance(moves[at].pose.tip, over(first, 1e9)) > 1e-9) {
        const double z =
            shop.field->deformation.flatten(moves[at].pose.tip + moves[at].pose.axis * kRadius).z;
        ASSERT_NEAR(z, shop.links.clearance_z, 1e-9);
        ASSERT_EQ(moves[at++].kind, MoveKind::kRapid);
      }
      take(over(first, 1e9), first.axis, MoveKind::kRapid);
      take(over(first, shop.links.approach), first.axis, MoveKind::kRapid);
      take(over(first, 0.0), first.axis, MoveKind::kPlunge);
      for (std::size_t i = 1; i < pass.size(); ++i) take(over(pass[i], 0.0), pass[i].axis, MoveKind::kCut);
      take(over(last, 1e9), last.axis, MoveKind::kRapid);
    }
    if (zigzag) reversed = !reversed;
  }
  EXPECT_EQ(at, moves.size());
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
  Shop shop(random_part(c, 40u + static_cast<unsigned>(std::get<1>(GetParam()))), c.frame, 2.5, 25.0,
            outside);
  shop.links.direction = std::get<1>(GetParam()) % 2 == 0 ? Direction::kZigzag : Direction::kOneWay;
  shop.links.lead_radius = 1.5;
  shop.links.join_distance = 4.0;
  int asked = 0;
  shop.links.allowed = [&](const EnvelopePoint& p) { return ++asked, !outside(p); };
  const Linked linked = shop.run();
  EXPECT_GE(asked, linked.joins > 0 ? 1 : 0);
  EXPECT_GE(linked.leads, 2u);
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
    const bool in =
        kind(i - 1) == MoveKind::kPlunge && kind(i - 2) == MoveKind::kPlunge && kind(i) == MoveKind::kCut;
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
    const Vec3 last = in ? -step(end + 1) : step(end), axis = linked.moves[i - 1].pose.axis;
    EXPECT_LT(angle_between(last, axis), 0.75 * kPi / 8.0 / 2.0 + 1e-6);
    EXPECT_EQ(kind(in ? end - 1 : end + 1), MoveKind::kRapid);
  }
  EXPECT_GT(arcs, linked.leads / 2);
  std::printf("%-7s leads %zu of %zu, joins %zu\n", c.name, static_cast<std::size_t>(linked.leads),
              static_cast<std::size_t>(linked.leads + linked.straight_ends),
              static_cast<std::size_t>(linked.joins));
}

INSTANTIATE_TEST_SUITE_P(Modes, RandomPart, testing::Combine(testing::Range(0, 5), testing::Range(0, 2)));

/// A tube round the whole ring, or a shell round the point or line.
CheckedMesh whole(const AxisFrame& frame, double rho) {
  const Deformation map(frame, rho);
  const double x = frame.mode == AxisMode::kLine ? 20.0 : kPi * map.scale_x();
  const double y = frame.mode == AxisMode::kPoint ? 0.49 * kPi * rho : kPi * rho;
  return sheet(
      frame, rho, {-x, -y, 0}, {x, y, 0}, 60, 24, [&](double, double) { return map.s() * rho; },
      [](int, int) { return true; });
}

struct TiltCase {
  const char* name;
  AxisMode mode;
  Vec3 up;  ///< in the frame's t, n, b
  double tilt_max;
  Along along;
};

TEST(Tilt, HoldsOnEveryWayOverTheClearanceSurface) {
  const Vec3 t = normalized(Vec3{0.2, 0.9, -0.3}), n = normalized(cross(t, Vec3{0.5, -0.2, 0.8}));
  for (const TiltCase& c : {TiltCase{"line", AxisMode::kLine, {0, 1, 0}, 130.0, Along::kY},
                            {"point, pole up", AxisMode::kPoint, {0, 0, 1}, 115.0, Along::kY},
                            {"point, leaning", AxisMode::kPoint, {0.4, 0.5, 0.6}, 100.0, Along::kX},
                            {"circle, ring level", AxisMode::kCircle, {0, 0, 1}, 110.0, Along::kX},
                            {"circle, ring leaning", AxisMode::kCircle, {0.1, 0.5, 0.8}, 95.0, Along::kX}}) {
    SCOPED_TRACE(c.name);
    const AxisFrame frame{
        c.mode, Sense::kOutward, {5, -8, 3}, t, n, c.mode == AxisMode::kCircle ? 60.0 : 0.0};
    const Vec3 up = normalized(t * c.up.x + n * c.up.y + cross(n, t) * c.up.z);
    Shop shop(whole(frame, 20.0), frame, 4.0, 20.0, {}, up, c.tilt_max, c.along);
    // One way round the line: from the end of a pass to the start of the next it is short under the table.
    if (c.mode == AxisMode::kLine) shop.links.direction = Direction::kOneWay;
    shop.links.order = PassOrder::kGiven;
    const Linked linked = shop.run();
    ASSERT_GT(linked.retracts, 5u);
    EXPECT_EQ(linked.tilted_passes + linked.skipped_passes, 0u);
    EXPECT_LE(widest_tilt(linked, up), Angle::from_degrees(c.tilt_max).radians() + 2e-6);
    EXPECT_LE(proof(shop, linked).rapid_overlap, kTolerance / 2.0);
    shop.links.tilt_max = Angle::from_degrees(180.0);
    EXPECT_GT(widest_tilt(shop.run(), up), Angle::from_degrees(c.tilt_max).radians() + 1e-4);
  }
}

TEST(Tilt, TheLongWayRoundWhereTheShortOneGoesUnderTheTable) {
  const AxisFrame frame{AxisMode::kLine, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};
  Shop shop(whole(frame, 20.0), frame, 8.0, 20.0);
  shop.links.up = {0, 0, 1};
  const double deg = shop.field->deformation.scale_y() * kPi / 180.0;
  for (const auto& [tilt, turn] : {std::pair{180.0, 160.0}, {120.0, 200.0}}) {
    shop.links.tilt_max = Angle::from_degrees(tilt);
    std::vector<Pose> poses;
    ASSERT_EQ(shop.travel().find({0, 100 * deg, 0}, {5, -100 * deg, 0}, poses), Travel::Way::kFound);
    double way = 0.0;
    Vec3 axis = shop.travel().pose({0, 100 * deg, 0}).axis;
    for (const Pose& pose : poses) way += angle_between(axis, pose.axis), axis = pose.axis;
    EXPECT_NEAR(Angle::from_radians(way).degrees(), turn, 1e-6);
    EXPECT_LT(distance(poses.back().tip, shop.travel().pose({5, -100 * deg, shop.links.clearance_z}).tip),
              1e-9);
  }
}

TEST(Tilt, WhatNoWayReachesIsLeftOutAndCounted) {
  // The axis leans less than 60 degrees from n on the outside of the ring's one half and on the inside of
  // the other; between them it lies along the ring's plane, square to n, or leans further.
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 60.0};
  Shop shop(whole(frame, 20.0), frame, 8.0, 20.0, {}, {0, 1, 0}, 60.0);
  const Linked linked = shop.run();
  EXPECT_GT(linked.tilted_passes, 0u);
  EXPECT_EQ(linked.skipped_passes, 0u);
  EXPECT_EQ(linked.retracts + linked.tilted_passes, shop.passes());
  EXPECT_LE(widest_tilt(linked, {0, 1, 0}), Angle::from_degrees(60.0).radians() + 2e-6);
}

TEST(Tilt, LeastCosineIsThatOfTheGreatCircle) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto any = [&] { return normalized(Vec3{normal(random), normal(random), normal(random)}); };
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = any(), b = any(), up = any();
    double least = 1.0;
    for (int k = 0; k <= 2000; ++k) least = std::min(least, dot(slerp(a, b, k / 2000.0), up));
    EXPECT_NEAR(least_cosine(a, b, up), least, 1e-5);
    EXPECT_NEAR(least_cosine(a, a, up), dot(a, up), 1e-15);
  }
}

/// A level sheet, 60 by 60, of another height where x is near 0.
template <class Height>
Shop valley(Height height, bool hole = false) {
  return Shop(
      sheet(
          kFixedFrame, 1.0, {-30, -30, 0}, {30, 30, 0}, 60, 60, [&](double x, double) { return height(x); },
          [&](int i, int) { return !(hole && i >= 25 && i < 35); }),
      kFixedFrame, 10.0);
}
const auto level = [](double, double = 0.0) { return 0.0; };

Joins::End end_at(Shop& shop, double x, double y) {
  const auto p = shop.envelope->at(x, y), in = shop.envelope->at(x + (x < 0.0 ? -0.5 : 0.5), y);
  return {*p, *in};
}

TEST(Join, OnlyWhereTheEnvelopeLeadsThere) {
  const auto joined = [](Shop& shop, double x) {
    shop.links.join_distance = 25.0, shop.links.plunge_ratio = 100.0;
    const Travel travel = shop.travel();
    Joins joins(*shop.field, shop.links, *shop.far_side, *shop.envelope, travel);
    return joins.between(end_at(shop, -x, 3.0), end_at(shop, x, 3.0));
  };
  Shop plain = valley(level), holed = valley(level, true);
  ASSERT_TRUE(joined(plain, 8.0));
  EXPECT_TRUE(joined(plain, 8.0)->empty());  // a straight move is all
  EXPECT_FALSE(joined(holed, 8.0));          // a gap
  EXPECT_FALSE(joined(plain, 12.6));         // too far
  plain.links.allowed = [](const EnvelopePoint& p) { return std::abs(p.flat.x) > 1.0; };
  EXPECT_FALSE(joined(plain, 8.0)) << "over points that may not be cut";
  plain.links.allowed = [](const EnvelopePoint&) { return true; };
  EXPECT_TRUE(joined(plain, 8.0));
}

TEST(Join, NotWhereUpAndOverIsQuicker) {
  Shop shop = valley([](double x) { return std::min(0.0, 3.0 * std::abs(x) - 20.0); });
  shop.links.join_distance = 25.0;
  const Travel travel = shop.travel();
  Joins joins(*shop.field, shop.links, *shop.far_side, *shop.envelope, travel);
  const auto a = end_at(shop, -9.0, 3.0), b = end_at(shop, 9.0, 3.0);
  shop.links.plunge_ratio = 1.0;
  EXPECT_FALSE(joins.between(a, b));
  shop.links.plunge_ratio = 100.0;
  const auto down_and_up = joins.between(a, b);
  ASSERT_TRUE(down_and_up);
  double lowest = 0.0, way = 0.0;
  Point<Part> at = a.point.centre;
  for (const EnvelopePoint& p : *down_and_up)
    lowest = std::min(lowest, p.centre.z), way += distance(at, p.centre), at = p.centre;
  EXPECT_NEAR(lowest, -20.0 + kRadius * std::sqrt(10.0), 0.1);  // the ball rests on both flanks
  shop.links.plunge_ratio = 0.0;                                // now up and over costs its rapids alone
  const double rapids = 2.0 * (shop.links.clearance_z - a.point.flat.z) + 18.0 - shop.links.approach;
  EXPECT_GT(way, rapids / 5.0);
  EXPECT_FALSE(joins.between(a, b));
}

TEST(Join, GoesBackIntoThePassesWhereTheOutlineIsHollow) {
  // A round hole: the straight line between two ends beside it crosses the hole.
  const auto in_hole = [](double x, double y) { return std::hypot(x, y) < 15.0; };
  Shop shop(sheet(kFixedFrame, 1.0, {-30, -30, 0}, {30, 30, 0}, 240, 240, level,
                  [&](int i, int j) { return !in_hole(-29.875 + 0.25 * i, -29.875 + 0.25 * j); }),
            kFixedFrame, 2.0);
  shop.links.join_distance = 5.0;
  const Linked linked = shop.run();
  EXPECT_LE(linked.retracts, 5u);
  EXPECT_GT(shop.passes(), 40u);
  expect_proven(shop, linked);
}

TEST(Join, NotAcrossWhatTheFarSideBlocks) {
  const AxisFrame frame{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 20.0};
  for (const double shank : {16.0, 60.0}) {
    Shop shop(whole(frame, 6.0), frame, 3.0, shank);
    shop.links.join_distance = 50.0, shop.links.plunge_ratio = 1000.0;
    const Travel travel = shop.travel();
    Joins joins(*shop.field, shop.links, *shop.far_side, *shop.envelope, travel);
    const double deg = shop.field->deformation.scale_y() * kPi / 180.0;
    const auto a = shop.envelope->at(3.0, 110.0 * deg), b = shop.envelope->at(3.0, -110.0 * deg);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(joins.between({*a, *a}, {*b, *b}).has_value(), shank < 20.0);
  }
}

TEST(Lead, IsAQuarterCircleOnALevelSheet) {
  Shop shop = valley(level);
  shop.links.lead_radius = 3.0;
  const Travel travel = shop.travel();
  Leads leads(*shop.field, shop.links, *shop.far_side, *shop.envelope, travel);
  const auto end = shop.envelope->at(0.0, 1.0), next = shop.envelope->at(1.0, 1.0);
  const auto arc = leads.arc(*end, *next);
  ASSERT_GE(arc.size(), 8u);
  for (const Point<Flat>& p : arc) EXPECT_NEAR(std::hypot(p.x, p.z - end->flat.z - 3.0), 3.0, 1e-9);
  EXPECT_NEAR(arc.back().x, -3.0, 1e-9);
  EXPECT_NEAR(arc.back().z, end->flat.z + 3.0, 1e-9);
  shop.links.lead_radius = kClearance + 0.1;  // its end would be over the clearance surface
  EXPECT_TRUE(leads.arc(*end, *next).empty());
  shop.links.lead_radius = kClearance - 0.1;
  EXPECT_FALSE(leads.arc(*end, *next).empty());
}

TEST(Lead, NotIntoAWallNorFromFarBelow) {
  // Level, a wall behind it, and a flank of 60 degrees further on.
  Shop shop = valley([](double x) {
    return x < -10.0 ? 8.0 : x < -9.0 ? 8.0 * (-9.0 - x) : x > 5.0 ? std::sqrt(3.0) * (x - 5.0) : 0.0;
  });
  shop.links.lead_radius = 3.0;
  const Travel travel = shop.travel();
  Leads leads(*shop.field, shop.links, *shop.far_side, *shop.envelope, travel);
  const auto arc = [&](double x, double towards) {
    const auto end = shop.envelope->at(x, 1.0), next = shop.envelope->at(x + towards, 1.0);
    return leads.arc(*end, *next);
  };
  EXPECT_FALSE(arc(-3.0, 0.5).empty());
  EXPECT_TRUE(arc(-5.0, 0.5).empty());    // the ball would cut the wall
  EXPECT_FALSE(arc(-5.0, -0.5).empty());  // the other way there is room
  EXPECT_TRUE(arc(15.0, 0.5).empty());    // up the flank
  EXPECT_FALSE(arc(15.0, -0.5).empty());  // down the flank: the arc is short and over it
  // No arc: straight down, and the pass is cut all the same.
  shop.slices = {{{*shop.envelope->at(-5.0, 1.0), *shop.envelope->at(-4.0, 1.0)}}};
  const Linked linked = shop.run();
  EXPECT_EQ(linked.leads, 1u);
  EXPECT_EQ(linked.straight_ends, 1u);
  ASSERT_GE(linked.moves.size(), 4u);
  EXPECT_EQ(linked.moves[2].kind, MoveKind::kPlunge);
  EXPECT_LT(distance(linked.moves[2].pose.tip, linked.moves[1].pose.tip), shop.links.approach + 1e-9);
}

TEST(Lead, KeepsTheTiltLimitAndMindsTheFarSide) {
  const AxisFrame point{AxisMode::kPoint, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.0};
  Shop shell(whole(point, 25.0), point, 4.0, 20.0, {}, {0, 1, 0}, 50.0);
  const AxisFrame ring{AxisMode::kCircle, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 20.0};
  Shop hole(whole(ring, 6.0), ring, 3.0, 60.0);
  const auto arc = [](Shop& shop, double x, double y, double next_x, double next_y) {
    shop.links.lead_radius = 2.0;
    const Travel travel = shop.travel();
    Leads leads(*shop.field, shop.links, *shop.far_side, *shop.envelope, travel);
    const auto end = shop.envelope->at(x, y), next = shop.envelope->at(next_x, next_y);
    return leads.arc(*end, *next);
  };
  const double deg = shell.field->deformation.scale_x() * kPi / 180.0;
  EXPECT_TRUE(arc(shell, 49.0 * deg, 0.0, 48.0 * deg, 0.0).empty());   // outwards over 50 degrees
  EXPECT_FALSE(arc(shell, 49.0 * deg, 0.0, 50.0 * deg, 0.0).empty());  // inwards
  const double turn = hole.field->deformation.scale_y() * kPi / 180.0;
  double last = 0.0;  // the last place that the far side leaves free
  for (double y = 60.0; y < 180.0; y += 1.0) {
    std::vector<std::vector<Pass>> lines{{{*hole.envelope->at(0.0, y * turn)}}};
    if (hole.far_side->trim(lines) > 0) break;
    last = y;
  }
  ASSERT_GT(last, 60.0);
  ASSERT_LT(last, 179.0);
  EXPECT_TRUE(arc(hole, 0.0, last * turn, 0.0, (last - 1.0) * turn).empty());
  EXPECT_FALSE(arc(hole, 0.0, last * turn, 0.0, (last + 1.0) * turn).empty());
}

Pass row(double from, double to, double y) {
  Pass pass;
  for (const double x : {from, to}) {
    EnvelopePoint p;
    p.flat = {x, y, 0.0}, p.centre = {x, y, 0.0}, p.axis = {0, 0, 1};
    pass.push_back(p);
  }
  return pass;
}

TEST(Order, ACombIsCutFingerByFinger) {
  std::vector<std::vector<Pass>> slices;
  for (int k = 0; k < 10; ++k) slices.push_back({row(0, 10, k), row(20, 30, k)});
  for (int k = 10; k < 12; ++k) slices.push_back({row(0, 30, k)});
  const Deformation map(kFixedFrame, 1.0);
  Linking links;
  links.clearance_z = 5.0;
  const Order zigzag = region_order(slices, map, links);
  Order expected;
  for (std::uint32_t k = 0; k < 10; ++k) expected.push_back({k, 0, k % 2 == 1});
  for (std::uint32_t k = 10; k < 12; ++k) expected.push_back({k, 0, k % 2 == 1});
  for (std::uint32_t k = 0; k < 10; ++k) expected.push_back({9 - k, 1, true});
  for (std::size_t i = 0; i < 10; ++i) expected[12 + i].reversed = zigzag[12].reversed != (i % 2 == 1);
  EXPECT_EQ(zigzag, expected);
  links.direction = Direction::kOneWay;
  const Order one_way = region_order(slices, map, links);
  ASSERT_EQ(one_way.size(), zigzag.size());
  for (std::size_t i = 1; i < one_way.size(); ++i) {
    EXPECT_FALSE(one_way[i].reversed);
    EXPECT_TRUE(one_way[i].slice == one_way[i - 1].slice + 1 || one_way[i].slice == 0 ||
                one_way[i].slice == 10);
  }
  EXPECT_EQ(plain_order(slices, Direction::kZigzag)[1], (Travelled{0, 1, false}));
  EXPECT_EQ(plain_order(slices, Direction::kZigzag)[2], (Travelled{1, 1, true}));
}

TEST(Order, HoldsAHundredThousandPassesOnceEachAndFinishesRegions) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> gap(0.3, 6.0);
  std::vector<std::vector<Pass>> slices;
  std::size_t count = 0;
  for (int k = 0; k < 1000; ++k) {
    slices.emplace_back();
    for (double x = gap(random); slices.back().size() < 100;) {
      const double to = x + gap(random);
      slices.back().push_back(row(x, to, k));
      x = to + gap(random), ++count;
    }
  }
  ASSERT_EQ(count, 100000u);
  const Deformation map(kFixedFrame, 1.0);
  Linking links;
  links.clearance_z = 5.0;
  const Order order = region_order(slices, map, links);
  std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  for (const Travelled& t : order) seen.insert({t.slice, t.pass});
  EXPECT_EQ(order.size(), count);
  EXPECT_EQ(seen.size(), count);
  // By brute force: a pass with one neighbour in the next slice that has but this one in turn is travelled
  // next to it, and the other way.
  const auto touching = [&](const Pass& pass, std::uint32_t slice) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t p = 0; p < slices[slice].size(); ++p) {
      const Pass& other = slices[slice][p];
      if (other.front().flat.x <= pass.back().flat.x && pass.front().flat.x <= other.back().flat.x)
        found.push_back(p);
    }
    return found;
  };
  std::vector<std::vector<std::size_t>> place(slices.size(), std::vector<std::size_t>(100));
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i].slice][order[i].pass] = i;
  std::size_t pairs = 0;
  for (std::uint32_t s = 0; s + 1 < slices.size(); s += 9)
    for (std::uint32_t p = 0; p < slices[s].size(); ++p) {
      const auto next = touching(slices[s][p], s + 1);
      if (next.size() != 1 || touching(slices[s + 1][next[0]], s).size() != 1) continue;
      ++pairs;
      const std::size_t a = place[s][p], b = place[s + 1][next[0]];
      EXPECT_EQ(std::max(a, b) - std::min(a, b), 1u);
      EXPECT_NE(order[a].reversed, order[b].reversed);
    }
  EXPECT_GT(pairs, 500u);
}

TEST(Order, TheNearestEndIsTheNearest) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> grid(0, 9);  // many equals
  std::vector<Point<Part>> points;
  for (int i = 0; i < 700; ++i)
    points.push_back({1.0 * grid(random), 1.0 * grid(random), 1.0 * (grid(random) / 5)});
  NearestEnds ends(points);
  std::set<std::uint32_t> left;
  for (std::uint32_t i = 0; i < points.size(); ++i) left.insert(i);
  while (!left.empty()) {
    const Point<Part> from{0.9 * grid(random), 1.1 * grid(random), 0.5};
    std::uint32_t best = *left.begin();
    for (const std::uint32_t i : left)
      if (squared_length(points[i] - from) < squared_length(points[best] - from)) best = i;
    ASSERT_EQ(ends.nearest(from), best);
    ends.remove(best), left.erase(best);
  }
  EXPECT_FALSE(ends.nearest({0, 0, 0}));
}

}  // namespace
}  // namespace tiltfeed
