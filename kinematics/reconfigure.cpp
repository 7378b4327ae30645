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

}  // namespace

double rise_to(double clear_height, const Pose& pose, Vec3 up) {
  return std::max(0.0, (clear_height - dot(from_origin(pose.tip), up)) / dot(pose.axis, up));
}

ToolPath with_reconfigurations(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                               const OperationPlan& plan, double clear_height) {
  const Vec3 up = rotary_up(machine, setup);
  ToolPath out = path;
  out.moves.clear();
  std::size_t next = 0;
  for (const Reconfiguration& change : plan.changes) {
    const Move& at = path.moves[change.after];
    out.moves.insert(out.moves.end(), path.moves.begin() + static_cast<std::ptrdiff_t>(next),
                     path.moves.begin() + static_cast<std::ptrdiff_t>(change.after) + 1);
    next = change.after + 1;
    Detour(machine, setup, at, out.moves)
        .make(change.from.joints, change.to.joints, rise_to(clear_height, at.pose, up));
  }
  out.moves.insert(out.moves.end(), path.moves.begin() + static_cast<std::ptrdiff_t>(next), path.moves.end());
  return out;
}

}  // namespace tiltfeed
