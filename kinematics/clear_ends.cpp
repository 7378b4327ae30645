#include "kinematics/clear_ends.h"

#include <algorithm>
#include <utility>

#include "kinematics/operation.h"

namespace tiltfeed {
namespace {

/// Raised to the clear height along its axis; itself where it is there already, or lies too flat.
Pose raised(const Pose& pose, Vec3 up, double clear_height) {
  if (dot(pose.axis, up) < kLeastRise) return pose;
  return {pose.tip + pose.axis * rise_to(clear_height, pose, up), pose.axis};
}

}  // namespace

AptOperation with_clear_ends(AptOperation operation, const MachineModel& machine, const Setup& setup,
                             double clear_height) {
  const Vec3 up = rotary_up(machine, setup);
  std::vector<Move>& moves = operation.path.moves;
  const Pose first = moves.front().pose, last = moves.back().pose;
  const Pose above = raised(first, up, clear_height), off = raised(last, up, clear_height);
  if (!(off == last)) {
    moves.push_back({off, MoveKind::kRapid, kNoFacet});
    operation.lines.push_back(operation.lines.back());
  }
  if (above == first) return operation;
  moves.insert(moves.begin(), {above, MoveKind::kRapid, kNoFacet});
  operation.lines.insert(operation.lines.begin(), operation.lines.front());
  for (FeedChange& change : operation.path.feeds) ++change.move;
  // What comes before the first move comes before the way down to it.
  for (PathEvent& event : operation.events)
    if (event.move > 0) ++event.move;
  return operation;
}

AptOperation reconfigured(AptOperation operation, const JointPath& joints) {
  if (!joints.reconfigured) return operation;
  const std::vector<std::uint32_t>& planned = joints.planned;
  for (PathEvent& event : operation.events)
    event.move = static_cast<std::size_t>(std::lower_bound(planned.begin(), planned.end(), event.move) -
                                          planned.begin());
  std::vector<std::uint32_t> lines;
  for (const std::uint32_t move : planned) lines.push_back(operation.lines[move]);
  operation.lines = std::move(lines);
  operation.path = *joints.reconfigured;
  return operation;
}

}  // namespace tiltfeed
