#include <algorithm>
#include <cmath>

#include "kinematics/operation.h"

namespace tiltfeed {
namespace {

// Largest step of tilt and rotary between two stated poses, degrees: small enough that the nearest solution
// leads on, the walk subdivides further as it must.
constexpr double kTiltStep = 5.0;
constexpr double kRotaryStep = 15.0;
// The tool is set down as a plunge over this way, mm.
constexpr double kSetDown = 2.0;

/// The poses of one reconfiguration.
class Detour {
 public:
  Detour(const MachineModel& machine, const Setup& setup, const Move& at, std::vector<Move>& out)
      : machine_(machine), setup_(setup), at_(at), out_(out) {}

  void make(const Joints& from, const Joints& to, double rise) {
    const Pose raised{at_.pose.tip + at_.pose.axis * rise, at_.pose.axis};
    if (rise > 0.0) rapid(raised);
    const int tilts = steps(to.a - from.a, kTiltStep), turns = steps(to.c - from.c, kRotaryStep);
    for (int i = 1; i <= tilts; ++i) turned(raised.tip, from.a + (to.a - from.a) * i / tilts, from.c);
    for (int i = 1; i < turns; ++i) turned(raised.tip, to.a, from.c + (to.c - from.c) * i / turns);
    rapid(raised);
    if (rise > kSetDown) rapid({at_.pose.tip + at_.pose.axis * kSetDown, at_.pose.axis});
    if (rise > 0.0)
      out_.push_back(
          {at_.pose, at_.kind == MoveKind::kRapid ? MoveKind::kRapid : MoveKind::kPlunge, at_.facet});
  }

 private:
  static int steps(double way, double step) { return static_cast<int>(std::ceil(std::abs(way) / step)); }
  void rapid(const Pose& pose) { out_.push_back({pose, MoveKind::kRapid, kNoFacet}); }
  void turned(Point<Part> tip, double a, double c) {
    rapid({tip, normalized(forward(machine_, setup_, {0.0, 0.0, 0.0, a, c}).axis)});
  }

  const MachineModel& machine_;
  const Setup& setup_;
  const Move& at_;
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

ToolPath with_reconfigurations(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                               const OperationPlan& plan, double clear_height,
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
  for (const Reconfiguration& change : plan.changes) {
    const Move& at = path.moves[change.after];
    keep_to(change.after + 1);
    Detour(machine, setup, at, out.moves)
        .make(change.from.joints, change.to.joints, rise_to(clear_height, at.pose, up));
    planned.resize(out.moves.size(), static_cast<std::uint32_t>(change.after));
  }
  keep_to(path.moves.size());
  out.feeds = feeds_of(path, out.moves, planned);
  return out;
}

}  // namespace tiltfeed
