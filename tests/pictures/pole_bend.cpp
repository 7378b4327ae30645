// A path past the rotary's pole, exactly and bent: the tool axis as seen from the pole, C, tilt, C's speed.

#include "kinematics/joints/pole_bend.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "kinematics/joints/joint_path.h"
#include "tests/pictures/pictures.h"
#include "tests/pictures/svg.h"

namespace tiltfeed::pictures {
namespace {

constexpr double kOff = 1.0, kLeave = 2.0;  // degrees: of the pole from the path, of leave to lean
constexpr double kSweep = 20.0;             // degrees of tilt to each side
constexpr double kLength = 40.0;            // mm of the path
constexpr const char* kExact = "stroke=\"#c2410c\" stroke-width=\"2\"";
constexpr const char* kBent = "stroke=\"#1d4ed8\" stroke-width=\"2\"";

MachineModel machine() {
  MachineModel m;
  m.name = "picture";
  m.x = m.y = m.z = {-1000, 1000, 12000, 2000};
  m.tilt = {'A', {1, 0, 0}, +1, 0.0, -120, 120, 5400, 1000};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -36000, 36000, 7200, 1000};
  m.pivot_to_gauge = {0, 0, -150};
  return m;
}

/// The axis goes on a great circle kOff beside the pole while the tip goes straight on.
ToolPath path() {
  const double d = Angle::from_degrees(kOff).radians(), t = Angle::from_degrees(kSweep).radians();
  const Vec3 nearest{0, std::sin(d), std::cos(d)}, along{1, 0, 0};
  ToolPath path;
  path.name = "picture";
  path.tool = {6.0, 3.0, 100.0};
  path.cut_feed = Feed::from_mm_per_min(1200), path.plunge_feed = Feed::from_mm_per_min(300);
  const int count = 80;
  for (int i = 0; i <= count; ++i) {
    const double s = t * (2.0 * i / count - 1.0);
    path.moves.push_back({{{kLength * (1.0 * i / count), 0, 0}, nearest * std::cos(s) + along * std::sin(s)},
                          i == 0 ? MoveKind::kRapid : MoveKind::kCut,
                          kNoFacet});
  }
  return path;
}

/// Joints over the way of the tip.
struct Ways {
  Line c, tilt, speed;  ///< degrees, degrees, degrees/s at the programmed feed
};
Result<Ways> ways_of(const ToolPath& path, const MachineModel& m, const Setup& setup) {
  JointPathOptions options;
  options.tolerance = 0.01;
  const auto joints = to_joints(path, m, setup, options);
  if (!joints) return tl::unexpected(joints.error());
  Ways ways;
  double way = 0.0;
  for (std::size_t i = 0; i < joints->moves.size(); ++i) {
    const Joints& q = joints->moves[i].joints;
    if (i > 0) {
      const Joints& p = joints->moves[i - 1].joints;
      const double step = distance(forward(m, setup, p).tip, forward(m, setup, q).tip);
      if (step > 1e-9) {
        const double speed = std::abs(q.c - p.c) / step * path.cut_feed.mm_per_s();
        ways.speed.push_back({way, speed}), ways.speed.push_back({way + step, speed});
      }
      way += step;
    }
    ways.c.push_back({way, q.c}), ways.tilt.push_back({way, q.a});
  }
  return ways;
}

/// The tool axis' tip as seen down the rotary's axis, degrees from the pole.
Line seen_from_the_pole(const ToolPath& path) {
  Line line;
  for (const Move& move : path.moves) {
    const Vec3 u = move.pose.axis;
    const double off = Angle::from_radians(std::acos(std::clamp(u.z, -1.0, 1.0))).degrees();
    const double across = std::hypot(u.x, u.y);
    line.push_back(across > 0.0 ? At{off * u.x / across, off * u.y / across} : At{});
  }
  return line;
}

/// What of a line of rising x is within `most` of 0.
Line within(const Line& line, double most) {
  Line out;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const At p = line[i], q = line[i + 1];
    const auto at = [&](double x) { return At{x, p.y + (q.y - p.y) * (x - p.x) / (q.x - p.x)}; };
    if (q.x < -most || p.x > most) continue;
    if (out.empty()) out.push_back(p.x < -most ? at(-most) : p);
    out.push_back(q.x > most ? at(most) : q);
  }
  return out;
}

double range(const Line& line, const std::function<double(At)>& value) {
  const auto [low, high] =
      std::minmax_element(line.begin(), line.end(), [&](At a, At b) { return value(a) < value(b); });
  return value(*high) - value(*low);
}

}  // namespace

Result<void> draw_pole_bend(const std::string& file) {
  const MachineModel m = machine();
  Setup setup;
  setup.part_zero = {20, -10, 60};
  setup.tool_length = 100;
  const ToolPath exact = path();
  const PoleBend bent = bend_at_pole(exact, m, setup, {Angle::from_degrees(kLeave), 0.001},
                                     [](const Pose&, const Pose&) { return true; });
  const auto with = ways_of(bent.path, m, setup), without = ways_of(exact, m, setup);
  if (!with) return tl::unexpected(with.error());
  if (!without) return tl::unexpected(without.error());

  Svg svg(900, 560, "A path past the pole, followed exactly and bent");
  const Plot seen = even_plot({55, 70}, {-8, -3}, {8, 3}, 25.0);
  seen.grid(svg, {2, 2}, "lean of the tool axis to x, degrees", "to y, degrees");
  svg.circle(seen.at(At{}), 4, "fill=\"#333\"");
  svg.text({seen.at(At{}).x + 8, seen.at(At{}).y + 16}, "pole");
  svg.path(seen.at(within(seen_from_the_pole(exact), 8)), kExact);
  svg.path(seen.at(within(seen_from_the_pole(bent.path), 8)), kBent);
  const Plot c{{540, 70}, 340, 150, {0, -120}, {kLength, 120}};
  c.grid(svg, {5, 30}, "way of the tip, mm", "C, degrees");
  svg.path(c.at(without->c), kExact), svg.path(c.at(with->c), kBent);
  const Plot tilt{{55, 300}, 400, 200, {0, -25}, {kLength, 25}};
  tilt.grid(svg, {5, 10}, "way of the tip, mm", "A (tilt), degrees");
  svg.path(tilt.at(without->tilt), kExact), svg.path(tilt.at(with->tilt), kBent);
  const Plot speed{{540, 300}, 340, 200, {0, 0}, {kLength, 1200}};
  speed.grid(svg, {5, 200}, "way of the tip, mm", "speed of C at the programmed feed, degrees/s");
  const double most = m.rotary.velocity / 60.0;
  svg.line(speed.at({0, most}), speed.at({kLength, most}), "stroke=\"#333\" stroke-dasharray=\"6 3\"");
  svg.text({speed.at({kLength, most}).x - 4, speed.at({0, most}).y - 6},
           "C at its fastest: " + fixed(most, 0) + " degrees/s", "text-anchor=\"end\"");
  svg.path(speed.at(without->speed), kExact), svg.path(speed.at(with->speed), kBent);
  legend(
      svg, {55, 24}, kExact,
      "followed exactly: C turns by " + fixed(range(without->c, [](At p) { return p.y; }), 0) + " degrees");
  legend(svg, {370, 24}, kBent,
         "bent by at most " + fixed(bent.report.largest.degrees(), 1) + " of " + fixed(kLeave, 0) +
             " degrees allowed: C turns by " + fixed(range(with->c, [](At p) { return p.y; }), 0) +
             " degrees");
  return svg.write(file);
}

}  // namespace tiltfeed::pictures
