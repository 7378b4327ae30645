// The wished direction of a free tool axis, and how fast it may turn, in closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "config/job.h"
#include "pathgen/free_axis/pass_curve.h"
#include "pathgen/plan/plan.h"
#include "tests/shapes/soup.h"

namespace tiltfeed {
using namespace pathgen;
using namespace config;
namespace {

/// A cube's top, far from its rims, is cut to and fro: everywhere the axis leans by lead forwards along the
/// feed and by lean to its left. Between two points of a slice its normal turns evenly, so that it is off by
/// as much as the arcs round the rims turn within the tolerance; the same to both sides.
TEST(FreeWish, LeansByLeadAlongTheFeedAndByLeanToItsLeft) {
  constexpr double kNormals = 0.03;  // rad
  const CheckedMesh part = soup::check(soup::cube(0, 120));
  for (const Vec3 across : {Vec3{1, 0, 0}, normalized(Vec3{1, 2, 0})}) {
    PlanOptions o;
    o.cutter = {.diameter = 6, .length = 90, .shank_length = 60};
    o.axis.mode = AxisMode::kFree;
    o.free.plane_normals = {across};
    o.free.lead = Angle::from_degrees(12), o.free.lean = Angle::from_degrees(-7);
    o.free.max_turn = Angle::from_degrees(8), o.free.smoothing = 3;
    o.pattern.side_step = 15;
    o.max_point_distance = 5;
    o.links.clearance = 3, o.links.approach = 1;
    o.cut_feed = Feed::from_mm_per_min(1000), o.plunge_feed = Feed::from_mm_per_min(300);
    const auto made = plan(part, o, {});
    ASSERT_TRUE(made) << made.error().message;
    std::set<int> ways;
    int seen = 0;
    double leads = 0.0, leans = 0.0;
    const std::vector<Move>& moves = made->path.moves;
    for (std::size_t i = 1; i < moves.size(); ++i) {
      const auto centre = [&](std::size_t k) {
        return moves[k].pose.tip + moves[k].pose.axis * o.cutter.radius();
      };
      const Point<Part> a = centre(i - 1), b = centre(i);
      const bool in_middle =
          std::abs(b.z - 123.0) < 1e-6 && std::max(std::abs(b.x - 60), std::abs(b.y - 60)) < 30;
      if (moves[i].kind != MoveKind::kCut || !in_middle || distance(a, b) < 1e-3) continue;
      const Vec3 feed = normalized(b - a), left = cross(Vec3{0, 0, 1}, feed), axis = moves[i].pose.axis;
      const double lead = std::atan2(dot(axis, feed), axis.z) - o.free.lead.radians();
      const double lean = std::atan2(dot(axis, left), axis.z) - o.free.lean.radians();
      EXPECT_LE(std::max(std::abs(lead), std::abs(lean)), kNormals);
      leads += lead, leans += lean;
      ways.insert(dot(feed, cross(across, {0, 0, 1})) > 0.0 ? 1 : -1);
      ++seen;
    }
    EXPECT_EQ(ways.size(), 2u);
    EXPECT_GT(seen, 20);
    EXPECT_NEAR(leads / seen, 0.0, 1e-3);
    EXPECT_NEAR(leans / seen, 0.0, 1e-3);
  }
}

/// Round a rim the normal turns evenly over a quarter circle of the ball's radius R. Its mean over a length L
/// about the circle's start is the integral over L / 2 of the flat and as much of the arc.
TEST(FreeWish, IsTheMeanNormalOverTheSmoothingLength) {
  constexpr double kR = 4.0, kFlat = 20.0;
  constexpr int kPieces = 2000;
  ClChain chain;
  chain.points.push_back({{-kFlat, 0, kR}, {0, 0, 1}, 0});
  for (int i = 0; i <= kPieces; ++i) {
    const double q = kPi / 2 * i / kPieces;
    const Vec3 n{std::sin(q), 0, std::cos(q)};
    chain.points.push_back({Point<Part>{} + n * kR, n, 0});
  }
  chain.points.push_back({{kR, 0, -kFlat}, {1, 0, 0}, 0});
  const auto tilt = [](Vec3 v) { return std::atan2(v.x, v.z); };
  for (const double smoothing : {0.5, 2.0, 4.0, 8.0}) {
    FreeAxis wish;
    wish.smoothing = smoothing;
    const PassCurve curve(chain, wish);
    const double arc = kPi / 2 * kR, q = smoothing / (2.0 * kR);
    EXPECT_NEAR(curve.length(), 2 * kFlat + arc, 1e-5);
    // At the start of the arc, in its middle, and at its end.
    const double at_start = std::atan2(kR * (1 - std::cos(q)), smoothing / 2 + kR * std::sin(q));
    EXPECT_NEAR(tilt(curve.wished(kFlat)), at_start, 1e-6) << smoothing;
    EXPECT_NEAR(tilt(curve.wished(kFlat + arc / 2)), kPi / 4, 1e-6) << smoothing;
    EXPECT_NEAR(tilt(curve.wished(kFlat + arc)), kPi / 2 - at_start, 1e-6) << smoothing;
    EXPECT_NEAR(tilt(curve.wished(kFlat - smoothing / 2 - 0.01)), 0.0, 1e-12) << smoothing;
  }
}

std::string job_text(double feed, const std::string& more) {
  return "part: {name: p-1, stl: p.stl}\n"
         "cutter: {type: ball, diameter_mm: 6, length_mm: 100, shank_length_mm: 60}\n"
         "axis: {mode: free, plane_normals: [[0, 0, 1], [1, 0, 0]]" +
         more +
         "}\n"
         "pattern: {side_step_mm: 4}\n"
         "clearance_mm: 5\n"
         "approach_mm: 1\n"
         "feeds: {cut_mm_per_min: " +
         std::to_string(feed) +
         ", plunge_mm_per_min: 300}\n"
         "setup: {part_zero_mm: [1, 2, 3]}\n"
         "machine: ../machines/generic-ac.yaml\n";
}
const std::string kPath = SOURCE_DIR "/config/jobs/t.yaml";

/// Of all cutting moves the fastest turn of the axis at the feed of the tip, degrees/min.
double fastest_turn(const ToolPath& path, Feed feed) {
  double most = 0.0;
  for (std::size_t i = 1; i < path.moves.size(); ++i) {
    const Pose &a = path.moves[i - 1].pose, &b = path.moves[i].pose;
    const double turn = Angle::from_radians(angle_between(a.axis, b.axis)).degrees();
    if (path.moves[i].kind == MoveKind::kCut && turn > 1e-6)
      most = std::max(most, turn / distance(a.tip, b.tip) * feed.mm_per_min());
  }
  return most;
}

/// The profile's head tilts at 7200 degrees/min: no pass asks for more at its feed, unless the job says so.
TEST(FreeTurn, StaysWithinWhatTheMachinesTiltCanDoAtTheFeed) {
  soup::Soup torus = soup::torus();
  for (auto& f : torus)
    for (Point<Part>& p : f) p = {p.x * 4, p.y * 4, p.z * 4};
  const CheckedMesh part = soup::check(torus);
  for (const double feed : {1500.0, 4000.0}) {
    const auto job = parse_job(job_text(feed, ""), kPath);
    ASSERT_TRUE(job) << job.error().message;
    const auto made = plan(part, job->plan, {});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_LE(fastest_turn(made->path, job->plan.cut_feed), 7200.0 * (1 + 1e-6)) << feed;
    EXPECT_GT(fastest_turn(made->path, job->plan.cut_feed), 7200.0 * 0.4) << feed;
  }
  const auto job = parse_job(job_text(4000.0, ", max_turn_deg_per_mm: 8"), kPath);
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_NEAR(job->plan.free.max_turn.degrees(), 8.0, 1e-12);
  EXPECT_GT(fastest_turn(plan(part, job->plan, {})->path, job->plan.cut_feed), 7200.0 * 2);
}

/// Slow feeds are limited by the cutter; fast ones by tilt speed t per mm of the tip's way, which is as long
/// as the ball centre's but for what the ball rolls: t (1 - R turn) = turn.
TEST(FreeTurn, ItsDefaultIsTheLesserOfCutterAndMachine) {
  const auto turn = [](double feed) { return parse_job(job_text(feed, ""), kPath)->plan.free.max_turn; };
  EXPECT_NEAR(turn(200.0).degrees(), 25.0 / 3.0, 1e-9);
  for (const double feed : {1500.0, 4000.0, 20000.0}) {
    const double at = turn(feed).radians();
    EXPECT_NEAR(at, Angle::from_degrees(7200.0 / feed).radians() * (1.0 - 3.0 * at), 1e-12) << feed;
  }
}

/// A pass may end with the same place twice.
TEST(PassCurve, ItsEndIsAPlaceWhereItsLastPointIsRepeated) {
  ClChain chain;
  for (const double x : {0.0, 1.0, 3.0, 3.0, 3.0}) chain.points.push_back({{x, 0, 0}, {0, 0, 1}});
  const PassCurve curve(chain, {});
  for (const double way : {2.0, curve.length(), curve.length() + 1.0})
    EXPECT_EQ(curve.at(way).centre.x, std::min(way, 3.0));
  EXPECT_NEAR(curve.wished(curve.length()).z, 1.0, 1e-12);
}

}  // namespace
}  // namespace tiltfeed
