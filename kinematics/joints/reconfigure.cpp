#include <algorithm>
#include <cmath>

#include "kinematics/joints/operation.h"

namespace tiltfeed {
namespace {

// Largest step of tilt and rotary between two stated poses, degrees: small enough that the nearest solution
// leads on, the walk subdivides further as it must.
constexpr double kTiltStep = 5.0;
constexpr double kRotaryStep = 15.0;
// Largest step of a rotary that turns the work below a standing tool, degrees: the tip's straight way between
// two poses comes nearer to the axis than both by 0.1 % of its distance.
constexpr double kOutwardStep = 5.0;
// The tool is set down as a plunge over this way, mm.
constexpr double kSetDown = 2.0;

/// The poses of one reconfiguration.
class Detour {
 public:
  Detour(const MachineModel& machine, const Setup& setup, std::vector<Move>& out)
      : machine_(machine), setup_(setup), out_(out) {}

  /// From one move's end to another's (the same for the rotaries only), at `off` and then `on` mm along their
  /// axes.
  void make(const Reconfiguration& change, const Move& from, double off, const Move& to, double on) {
    const Joints &before = change.from.joints, &after = change.to.joints;
    const Pose raised = along_axis(from.pose, off);
    if (off > 0.0) rapid(raised);
    if (change.outward)
      turn_work(raised, before, after.c);
    else
      turn_tool(raised, before, after);
    rapid(along_axis(to.pose, on));
    if (on > kSetDown) rapid(along_axis(to.pose, kSetDown));
    if (on > 0.0)
      out_.push_back({to.pose, to.kind == MoveKind::kRapid ? MoveKind::kRapid : MoveKind::kPlunge, to.facet});
  }

 private:
  /// With the tip held.
  void turn_tool(const Pose& raised, const Joints& from, const Joints& to) {
    const int tilts = steps(to.a - from.a, kTiltStep), turns = steps(to.c - from.c, kRotaryStep);
    for (int i = 1; i <= tilts; ++i) turned(raised.tip, from.a + (to.a - from.a) * i / tilts, from.c);
    for (int i = 1; i < turns; ++i) turned(raised.tip, to.a, from.c + (to.c - from.c) * i / turns);
  }
  /// With the tool standing.
  void turn_work(const Pose& raised, const Joints& from, double to_c) {
    Joints at = solve_linear(machine_, setup_, raised.tip, from.a, from.c);
    const int turns = steps(to_c - from.c, kOutwardStep);
    for (int i = 1; i < turns; ++i) {
      at.c = from.c + (to_c - from.c) * i / turns;
      const Pose pose = forward(machine_, setup_, at);
      rapid({pose.tip, normalized(pose.axis)});
    }
  }
  static Pose along_axis(const Pose& pose, double way) { return {pose.tip + pose.axis * way, pose.axis}; }
  static int steps(double way, double step) { return static_cast<int>(std::ceil(std::abs(way) / step)); }
  void rapid(const Pose& pose) { out_.push_back({pose, MoveKind::kRapid, kNoFacet}); }
  void turned(Point<Part> tip, double a, double c) {
    rapid({tip, normalized(forward(machine_, setup_, {0.0, 0.0, 0.0, a, c}).axis)});
  }

  const MachineModel& machine_;
  const Setup& setup_;
  std::vector<Move>& out_;
};

/// The feeds of the path by its new moves, and the plunges that are put in at plunge feed.
std::vector<FeedChange> feeds_of(const ToolPath& path, const std::vector<Move>& moves,
                                 const std::vector<std::uint32_t>& planned) {
  if (path.feeds.empty()) return {};  // then the kind of a move tells its feed
  std::vector<FeedChange> feeds;
  for (std::size_t i = 1; i < moves.size(); ++i) {
    if (moves[i].kind == MoveKind::kRapid) continue;
    const bool put_in = planned[i] == planned[i - 1];
    Feed feed = feed_of(path, planned[i]);
    if (put_in) feed = std::min(feed, path.plunge_feed);
    if (feeds.empty() || feeds.back().feed != feed) feeds.push_back({static_cast<std::uint32_t>(i), feed});
  }
  return feeds;
}

}  // namespace

double rise_to(double clear_height, const Pose& pose, Vec3 up) {
  return std::max(0.0, (clear_height - dot(from_origin(pose.tip), up)) / dot(pose.axis, up));
}

std::optional<double> way_out(double clear_radius, const Pose& pose, const MachineModel& machine,
                              const Setup& setup) {
  const Vec3 up = rotary_up(machine, setup);
  if (machine.structure == Structure::kHeadHead || dot(pose.axis, up) >= kLeastRise) return std::nullopt;
  // Across the rotary's axis, which passes through -w on the table.
  const Vec3 from_axis = from_origin(pose.tip) + transposed(setup.fixture) * setup.part_zero;
  const Vec3 p = from_axis - up * dot(from_axis, up), d = pose.axis - up * dot(pose.axis, up);
  const double dd = squared_length(d), pd = dot(p, d), off = squared_length(p) - clear_radius * clear_radius;
  // A shank that points to the axis would cross the work.
  if (!(dd > 0.0) || pd < 0.0) return std::nullopt;
  return off >= 0.0 ? 0.0 : (std::sqrt(pd * pd - dd * off) - pd) / dd;
}

ToolPath with_reconfigurations(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                               const OperationPlan& plan, const ClearSpace& clear,
                               std::vector<std::uint32_t>& planned) {
  const Vec3 up = rotary_up(machine, setup);
  ToolPath out = path;
  out.moves.clear();
  planned.clear();
  std::size_t next = 0;
  const auto keep_to = [&](std::size_t end) {
    for (; next < end; ++next) {
      out.moves.push_back(path.moves[next]);
      planned.push_back(static_cast<std::uint32_t>(next));
    }
  };
  const auto off = [&](const Reconfiguration& change, const Move& at) {
    return change.outward ? *way_out(*clear.radius, at.pose, machine, setup)
                          : rise_to(*clear.height, at.pose, up);
  };
  for (const Reconfiguration& change : plan.changes) {
    const Move &from = path.moves[change.after], &to = path.moves[change.after + (change.instead ? 1 : 0)];
    keep_to(change.after + 1);
    Detour(machine, setup, out.moves).make(change, from, off(change, from), to, off(change, to));
    planned.resize(out.moves.size(), static_cast<std::uint32_t>(change.after));
    if (change.instead) planned.back() = static_cast<std::uint32_t>(next++);
  }
  keep_to(path.moves.size());
  out.feeds = feeds_of(path, out.moves, planned);
  return out;
}

}  // namespace tiltfeed
