// Two paths past the rotary's pole, exactly and bent: the tool axis as seen from the pole, C, tilt, C's
// speed.

#include "kinematics/joints/singularity_bend.h"

#include <algorithm>
#include <cmath>

#include "kinematics/joints/joint_path.h"
#include "tests/pictures/pictures.h"
#include "tests/pictures/svg.h"

namespace tiltfeed::pictures {
namespace {

constexpr double kLeave = 2.0;              // by which the axis may lean, degrees
constexpr double kNear = 1.0, kFar = -3.5;  // of two paths from the pole, degrees
constexpr double kSweep = 20.0;             // degrees of tilt to each side
constexpr double kLength = 40.0;            // mm of the path
constexpr const char* kExact = "stroke-width=\"2\" stroke=\"#c2410c\"";
constexpr const char* kBent = "stroke-width=\"2\" stroke=\"#1d4ed8\"";

MachineModel machine() {
  MachineModel m;
  m.name = "picture";
  m.x = m.y = m.z = {-1000, 1000, 12000, 2000};
  m.tilt = {'A', {1, 0, 0}, +1, 0.0, -120, 120, 5400, 1000};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -36000, 36000, 7200, 1000};
  m.pivot_to_gauge = {0, 0, -150};
  return m;
}

/// The axis goes on a great circle beside the pole while the tip goes straight on.
ToolPath path(double off) {
  const double d = Angle::from_degrees(off).radians(), t = Angle::from_degrees(kSweep).radians();
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

double turn_of(const Line& c) {
  const auto [low, high] = std::minmax_element(c.begin(), c.end(), [](At a, At b) { return a.y < b.y; });
  return high->y - low->y;
}
double highest(const Line& line) {
  return std::max_element(line.begin(), line.end(), [](At a, At b) { return a.y < b.y; })->y;
}

struct Panels {
  Plot seen, c, tilt, speed;
};

Panels panels(Svg& svg, const MachineModel& m) {
  Panels on{even_plot({55, 100}, {-8, -6}, {8, 3}, 25.0),
            {{540, 100}, 340, 225, {0, -120}, {kLength, 120}},
            {{55, 405}, 400, 200, {0, -25}, {kLength, 25}},
            {{540, 405}, 340, 200, {0, 0}, {kLength, 1200}}};
  on.seen.grid(svg, {2, 1}, "lean of the tool axis to x, degrees", "to y, degrees");
  on.c.grid(svg, {5, 30}, "way of the tip, mm", "C, degrees");
  on.tilt.grid(svg, {5, 10}, "way of the tip, mm", "A (tilt), degrees");
  on.speed.grid(svg, {5, 200}, "way of the tip, mm", "speed of C at the programmed feed, degrees/s");
  svg.circle(on.seen.at(At{}), 4, "fill=\"#333\"");
  svg.text({on.seen.at(At{}).x + 8, on.seen.at(At{}).y + 16}, "pole");
  const double most = m.rotary.velocity / 60.0;
  svg.line(on.speed.at({0, most}), on.speed.at({kLength, most}), "stroke=\"#333\"");
  svg.text({on.speed.at({kLength, most}).x - 4, on.speed.at({0, most}).y - 6},
           "C at its fastest: " + fixed(most, 0), "text-anchor=\"end\"");
  return on;
}

/// The path so far off the pole, exactly and bent; its row of the legend is at `row`.
Result<void> draw(Svg& svg, const Panels& on, double off, const std::string& dashes, double row) {
  const MachineModel m = machine();
  Setup setup;
  setup.part_zero = {20, -10, 60};
  setup.tool_length = 100;
  const ToolPath exact = path(off);
  const SingularityBend bent = bend_at_singularity(exact, m, setup, {Angle::from_degrees(kLeave), 0.001},
                                                   [](const Pose&, const Pose&) { return true; });
  for (const bool bend : {false, true}) {
    const ToolPath& followed = bend ? bent.path : exact;
    const auto ways = ways_of(followed, m, setup);
    if (!ways) return tl::unexpected(ways.error());
    const std::string look = std::string(bend ? kBent : kExact) + dashes;
    svg.path(on.seen.at(within(seen_from_the_pole(followed), 8)), look);
    svg.path(on.c.at(ways->c), look);
    svg.path(on.tilt.at(ways->tilt), look);
    svg.path(straightened(on.speed.at(ways->speed), 0.2), look);
    const std::string what = bend ? "bent by " + fixed(bent.report.largest.degrees(), 1) + " degrees"
                                  : fixed(std::abs(off), 1) + " degrees off the pole";
    legend(svg, {bend ? 480.0 : 55.0, row}, look,
           what + ": C turns by " + fixed(turn_of(ways->c), 0) + ", up to " + fixed(highest(ways->speed), 0) +
               " degrees/s");
  }
  return {};
}

}  // namespace

Result<void> draw_pole_bend(const std::string& file) {
  Svg svg(900, 660, "Two paths past the pole, followed exactly and bent");
  const Panels on = panels(svg, machine());
  if (auto drawn = draw(svg, on, kNear, "", 24); !drawn) return drawn;
  if (auto drawn = draw(svg, on, kFar, " stroke-dasharray=\"6 3\"", 46); !drawn) return drawn;
  svg.text({55, 66}, "allowed lean: " + fixed(kLeave, 0) + " degrees");
  return svg.write(file);
}

}  // namespace tiltfeed::pictures
