// Engagement of the cutter against closed forms, and loads against a sum over the cutter's surface that knows
// where material is from formulas alone.

#include "sim/engagement/engagement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "sim/engagement/chip_gauge.h"
#include "sim/engagement/engagement_plot.h"
#include "sim/engagement/engagement_table.h"
#include "tests/shapes/plate_program.h"

namespace tiltfeed::sim {
namespace {

constexpr double kAsked = 1200.0;  // mm/min

/// Stock from (-30, -10, -10) to (30, 10, 0).
Stock bar_stock(double cell) { return stock_block({{-30, -10, -10}, {30, 10, 0}}, cell); }

/// Moves at feed through these poses, each as slow as F asks for, or slower by `slower`.
ExecutedPath through(const std::vector<Pose>& poses, double slower = 1.0) {
  ExecutedPath path;
  path.start = joints_for(poses.front());
  double at = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double asked = distance(poses[i - 1].tip, poses[i].tip) / kAsked * 60.0;
    path.moves.push_back({joints_for(poses[i]), at, at + asked * slower, asked, i, 0, false, false});
    at += asked * slower;
  }
  path.seconds = at;
  return path;
}

Engagement measured(const Cutter& cutter, const std::vector<Pose>& poses, Stock& stock, int threads = 2) {
  Job job = make_job();
  job.plan.cutter = cutter;
  const ExecutedPath path = through(poses);
  auto found = measure_engagement(job, path, stock, {engagement_step(cutter, stock.cell), threads}, {});
  EXPECT_TRUE(found) << found.error().message;
  return found.value_or(Engagement{});
}

/// Mean over the spans whose tip runs between these x.
SpanEngagement steady(const Engagement& e, double from, double to) {
  SpanEngagement mean;
  double count = 0.0;
  for (std::size_t i = 0; i < e.spans.size(); ++i) {
    if (std::min(e.spans[i].from.tip.x, e.spans[i].to.tip.x) < from ||
        std::max(e.spans[i].from.tip.x, e.spans[i].to.tip.x) > to)
      continue;
    const SpanEngagement& l = e.loads[i];
    mean.volume += l.volume / e.spans[i].way, mean.angle += l.angle, mean.depth += l.depth;
    mean.chip += l.chip, mean.edge_load += l.edge_load, mean.turn_load += l.turn_load;
    ++count;
  }
  EXPECT_GT(count, 5.0);
  for (double SpanEngagement::*v :
       {&SpanEngagement::volume, &SpanEngagement::angle, &SpanEngagement::depth, &SpanEngagement::chip,
        &SpanEngagement::edge_load, &SpanEngagement::turn_load})
    mean.*v /= count;
  return mean;
}

/// A place on the cutter's surface in the tool's own frame, z its axis.
struct SurfacePlace {
  Vec3 p, normal;
  double area = 0.0, angle = 0.0, radius = 0.0;
};

/// What the formulas say of a cutter whose surface is these places, that goes along `feed` (tool frame).
/// `material`: where the place is in material before it is cut.
SpanEngagement expected(const std::vector<SurfacePlace>& places, int angles, Vec3 feed,
                        const std::function<bool(Vec3)>& material) {
  SpanEngagement out;
  std::vector<double> load(angles, 0.0), chip(angles / 5, 0.0), volume(angles / 5, 0.0);
  double low = 1e9, high = -1e9;
  const double d_angle = 2.0 * kPi / angles;
  for (const SurfacePlace& s : places) {
    const double ahead = dot(s.normal, feed);
    if (ahead <= 0.0 || !material(s.p)) continue;
    const int column = static_cast<int>((s.angle + kPi) / d_angle) % angles;
    const double force = std::pow(ahead * kAsked, 0.75) * s.area;
    load[column] += force / (s.radius * d_angle);
    out.turn_load += force / (2.0 * kPi);
    out.volume += ahead * s.area;
    low = std::min(low, s.p.z), high = std::max(high, s.p.z);
    volume[column / 5] += ahead * s.area, chip[column / 5] += ahead * s.area * ahead * kAsked;
  }
  out.depth = high - low;
  out.edge_load = *std::max_element(load.begin(), load.end());
  for (int c = 0; c < angles / 5; ++c) {
    if (volume[c] >= 0.002 * out.volume) out.angle += 360.0 * 5 / angles;
    if (volume[c] >= 0.01 * out.volume) out.chip = std::max(out.chip, chip[c] / volume[c]);
  }
  return out;
}

std::vector<SurfacePlace> ball_places(double radius, int angles, int heights) {
  std::vector<SurfacePlace> places;
  for (int i = 0; i < angles; ++i)
    for (int k = 0; k < heights; ++k) {
      const double a = -kPi + (i + 0.5) * 2.0 * kPi / angles, t = (k + 0.5) * 0.5 * kPi / heights;
      const Vec3 n{std::sin(t) * std::cos(a), std::sin(t) * std::sin(a), -std::cos(t)};
      places.push_back({Vec3{0, 0, radius} + n * radius, n,
                        radius * radius * std::sin(t) * (0.5 * kPi / heights) * (2.0 * kPi / angles), a,
                        radius * std::sin(t)});
    }
  return places;
}

const Cutter kFlat4 = [] {
  Cutter flat{4, 100, 40};
  flat.type = CutterType::kFlat;
  return flat;
}();

// (engagement.h, properties 1 and 2)
TEST(Engagement, SlotOfAFlatMill) {
  Stock stock = bar_stock(0.25);
  const double before = stock.volume();
  const Engagement e = measured(kFlat4, {{{-34, 0.1, -2}, {0, 0, 1}}, {{34, 0.1, -2}, {0, 0, 1}}}, stock);
  const SpanEngagement s = steady(e, -20, 20);
  EXPECT_NEAR(s.angle, 180.0, 10.0);
  EXPECT_NEAR(s.depth, 2.0, 2 * 40.0 / 64);
  EXPECT_NEAR(s.volume, 4.0 * 2.0, 0.03 * 8.0);
  EXPECT_NEAR(s.chip, kAsked, 0.01 * kAsked);
  EXPECT_NEAR(s.edge_load, std::pow(kAsked, 0.75) * 2.0, 0.06 * std::pow(kAsked, 0.75) * 2.0);
  // The mean of cos^0.75 over the half turn in material: a beta function.
  const double half = std::sqrt(kPi) * std::tgamma(0.875) / std::tgamma(1.375);
  const double turn = std::pow(kAsked, 0.75) * 2.0 * 2.0 * half / (2.0 * kPi);
  EXPECT_NEAR(s.turn_load, turn, 0.03 * turn);
  const double removed = std::accumulate(e.loads.begin(), e.loads.end(), 0.0,
                                         [](double sum, const SpanEngagement& l) { return sum + l.volume; });
  EXPECT_NEAR(removed, before - stock.volume(), 0.02 * removed);
}

// (engagement.h, properties 2 and 3)
TEST(Engagement, ShoulderOfAFlatMill) {
  for (const double ae : {2.0, 1.0, 0.4}) {
    Stock stock = bar_stock(0.1);
    const double y = -10.0 - 2.0 + ae, q = ae / 4.0;
    const SpanEngagement s =
        steady(measured(kFlat4, {{{-34, y, -2}, {0, 0, 1}}, {{34, y, -2}, {0, 0, 1}}}, stock), -20, 20);
    const double angle = std::acos(1.0 - 2.0 * q) * 180.0 / kPi;
    EXPECT_NEAR(s.angle, angle, 11.0) << ae;
    EXPECT_NEAR(s.volume, ae * 2.0, 0.04 * ae * 2.0) << ae;
    const double chip = kAsked * 2.0 * std::sqrt(q * (1.0 - q));
    EXPECT_NEAR(s.chip, chip, 0.06 * chip) << ae;
  }
}

// (engagement.h, property 1, and (CH3), (CH4))
TEST(Engagement, BallInAPlane) {
  const double ap = 1.0, radius = 3.0;
  Stock stock = bar_stock(0.2);
  const SpanEngagement s = steady(
      measured({6, 100, 40}, {{{-36, 0.1, -ap}, {0, 0, 1}}, {{36, 0.1, -ap}, {0, 0, 1}}}, stock), -20, 20);
  const double half = std::acos((radius - ap) / radius);
  EXPECT_NEAR(s.volume, radius * radius * (half - std::sin(half) * std::cos(half)), 0.1);
  const SpanEngagement by_sum =
      expected(ball_places(radius, 360, 400), 360, {1, 0, 0}, [&](Vec3 p) { return p.z < ap; });
  EXPECT_NEAR(s.chip, by_sum.chip, 0.03 * kAsked);
  // No chip is thicker than where the ball leaves the plane.
  EXPECT_LT(s.chip, kAsked * std::sqrt(ap * (6.0 - ap)) / radius);
  EXPECT_NEAR(s.angle, by_sum.angle, 20.0);
  EXPECT_NEAR(s.depth, ap, 2 * 40.0 / 64);
  EXPECT_NEAR(s.turn_load, by_sum.turn_load, 0.05 * by_sum.turn_load);
  EXPECT_NEAR(s.edge_load, by_sum.edge_load, 0.12 * by_sum.edge_load);
}

// A ball that leans: forwards by 30 degrees, and to the side.
TEST(Engagement, LeaningBallInAPlane) {
  const double ap = 0.8, radius = 3.0;
  for (const Vec3 axis : {normalized({std::tan(kPi / 6), 0, 1}), normalized({0, -std::tan(kPi / 5), 1})}) {
    Stock stock = bar_stock(0.2);
    const auto at = [&](double x) { return Pose{Point<Part>{x, 0.1, radius - ap} - axis * radius, axis}; };
    const SpanEngagement s = steady(measured({6, 100, 40}, {at(-36), at(36)}, stock), -20, 20);
    // The tool's frame: x ahead, square to the axis.
    const Vec3 ahead = normalized(Vec3{1, 0, 0} - axis * axis.x), left = cross(axis, ahead);
    const Vec3 feed{dot(Vec3{1, 0, 0}, ahead), dot(Vec3{1, 0, 0}, left), axis.x};
    const SpanEngagement by_sum = expected(ball_places(radius, 360, 400), 360, feed, [&](Vec3 p) {
      const Vec3 q = p - Vec3{0, 0, radius};  // from the centre, which is radius - ap over the plane
      return radius - ap + ahead.z * q.x + left.z * q.y + axis.z * q.z < 0.0;
    });
    EXPECT_NEAR(s.volume, by_sum.volume, 0.06 * by_sum.volume);
    EXPECT_NEAR(s.angle, by_sum.angle, 20.0);
    EXPECT_NEAR(s.depth, by_sum.depth, 2 * 40.0 / 64);
    EXPECT_NEAR(s.chip, by_sum.chip, 0.05 * kAsked);
    EXPECT_NEAR(s.turn_load, by_sum.turn_load, 0.06 * by_sum.turn_load);
    EXPECT_NEAR(s.edge_load, by_sum.edge_load, 0.15 * by_sum.edge_load);
  }
}

// Air after the first way, and where there is no stock.
TEST(Engagement, NothingTwice) {
  Stock stock = bar_stock(0.25);
  const Engagement e = measured(
      kFlat4, {{{-34, 0, -2}, {0, 0, 1}}, {{34, 0, -2}, {0, 0, 1}}, {{-34, 0, -2}, {0, 0, 1}}}, stock);
  double back = 0.0, outside = 0.0;
  for (std::size_t i = 0; i < e.spans.size(); ++i) {
    if (e.spans[i].first_move == 1) back += e.loads[i].volume;
    if (e.spans[i].to.tip.x < -32.1) outside += e.loads[i].volume;
  }
  EXPECT_LT(back, 1e-3);
  EXPECT_EQ(outside, 0.0);
}

// (engagement.h, property 4) Short blocks, a wavy way, more of them than a batch has.
TEST(Engagement, SameOnAnyThreads) {
  std::vector<Pose> poses;
  for (int i = 0; i <= 9000; ++i)
    poses.push_back({{-25.0 + 50.0 * i / 9000, 5.0 * std::sin(i * 0.002), -1.5}, {0, 0, 1}});
  std::array<Engagement, 2> found;
  for (int i = 0; i < 2; ++i) {
    Stock stock = bar_stock(0.5);
    found[i] = measured({6, 100, 40}, poses, stock, i == 0 ? 1 : 4);
  }
  ASSERT_EQ(found[0].loads.size(), found[1].loads.size());
  for (std::size_t i = 0; i < found[0].loads.size(); ++i) {
    EXPECT_EQ(found[0].loads[i].edge_load, found[1].loads[i].edge_load) << i;
    EXPECT_EQ(found[0].loads[i].volume, found[1].loads[i].volume) << i;
  }
}

// (engaged_span.h, properties 1 to 3)
TEST(Engagement, SpansAreTheMoves) {
  std::vector<Pose> poses{{{-25, 0, 0}, {0, 0, 1}}};
  for (int i = 1; i <= 400; ++i)
    poses.push_back({{-25.0 + 0.11 * i, i % 7 == 0 ? 0.4 : 0.0, 0.0}, normalized({0.001 * i, 0, 1})});
  ExecutedPath path = through(poses, 1.5);
  for (std::size_t i = 90; i < 120; ++i) path.moves[i].rapid = true, path.moves[i].asked = 0.0;
  const Job job = make_job();
  const FrameChain chain(job.machine.model, job.setup);
  const auto spans = engaged_spans(path, chain, {0.5, 0.02, 20.0}, 0, path.moves.size());
  double asked = 0.0, took = 0.0;
  std::uint32_t move = 0;
  double share = 0.0;
  for (const EngagedSpan& span : spans) {
    if (share == 1.0) ++move, share = 0.0;
    EXPECT_EQ(span.first_move, move);
    EXPECT_NEAR(span.begin, share, 1e-12);
    move = span.last_move, share = span.end;
    for (std::uint32_t m = span.first_move; m <= span.last_move; ++m)
      EXPECT_EQ(path.moves[m].rapid, span.rapid);
    asked += span.asked, took += span.took;
  }
  EXPECT_EQ(move + 1, path.moves.size());
  double all = 0.0;
  for (const ExecutedMove& one : path.moves) all += one.asked;
  EXPECT_NEAR(asked, all, 1e-9);
  EXPECT_NEAR(took, path.seconds, 1e-9);
}

// (engagement_plot.h) The table read back; the picture has a line for each row, and the other program's
// behind.
TEST(Engagement, TableAndPicture) {
  Stock stock = bar_stock(0.5);
  Job job = make_job();
  job.plan.cutter = kFlat4;
  const ExecutedPath path = through({{{-34, 0, -2}, {0, 0, 1}}, {{34, 0, -2}, {0, 0, 1}}}, 1.25);
  const auto found = measure_engagement(job, path, stock, {engagement_step(kFlat4, 0.5), 1}, {});
  ASSERT_TRUE(found);
  std::ostringstream out;
  write_engagement(2, path, *found, out);
  std::istringstream in(kEngagementColumns + ("\n" + out.str()));
  std::vector<PlottedSpan> spans;
  double seconds = 0.0, most = 0.0;
  PlottedSpan span;
  for (std::string line; std::getline(in, line);)
    if (plotted_span(line, span)) {
      spans.push_back(span);
      EXPECT_EQ(span.operation, 2u);
      EXPECT_NEAR(span.feed, kAsked / 1.25, 0.01 * kAsked);
      seconds += span.seconds, most = std::max(most, span.load);
    }
  ASSERT_EQ(spans.size(), found->spans.size());
  EXPECT_NEAR(seconds, path.seconds, 1e-4);
  EXPECT_NEAR(most, std::pow(kAsked / 1.25, 0.75) * 2.0, 0.1 * most);
  const std::string alone = engagement_svg(spans, {}), both = engagement_svg(spans, spans);
  EXPECT_EQ(alone, engagement_svg(spans, {}));
  const auto lines = [](const std::string& svg) {
    std::size_t count = 0;
    for (std::size_t at = svg.find("<polyline"); at != svg.npos; at = svg.find("<polyline", at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(lines(alone), 4u);
  EXPECT_EQ(lines(both), 8u);
}

TEST(Engagement, PlacesCountFromTheLastBlock) {
  ExecutedPath path;
  // A retract, a block of three pieces, a block, a retract.
  const auto add = [&](double asked, bool rapid, bool off) {
    path.moves.push_back({{}, 0.0, 1.0, asked, 0, 0, rapid, off});
  };
  add(0, true, true), add(1, false, true), add(2, false, true), add(1, false, false), add(1, false, false),
      add(0, true, true);
  const BlockPlaces places(path);
  EXPECT_EQ(places.at(1, 0.0).behind, 1u);
  EXPECT_DOUBLE_EQ(places.at(1, 0.5).share, 0.125);
  EXPECT_DOUBLE_EQ(places.at(2, 1.0).share, 0.75);
  EXPECT_EQ(places.at(3, 1.0).behind, 1u);
  EXPECT_DOUBLE_EQ(places.at(3, 1.0).share, 1.0);
  EXPECT_EQ(places.at(4, 0.0).behind, 0u);
  EXPECT_DOUBLE_EQ(places.at(4, 0.5).share, 0.5);
}

}  // namespace
}  // namespace tiltfeed::sim
