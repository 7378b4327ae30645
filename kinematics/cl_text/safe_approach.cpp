#include "kinematics/cl_text/safe_approach.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "kinematics/basics/decimal.h"
#include "kinematics/basics/units.h"
#include "kinematics/joints/joint_errors.h"
#include "kinematics/joints/operation.h"

namespace tiltfeed {
namespace {

/// Raised to the clear height along its axis; itself where it is there already, or lies too flat.
Pose raised(const Pose& pose, Vec3 up, double clear_height) {
  if (dot(pose.axis, up) < kLeastRise) return pose;
  return {pose.tip + pose.axis * rise_to(clear_height, pose, up), pose.axis};
}

// What is advised stays so far within the travels, mm.
constexpr double kRoom = 0.1;
// Words are rounded: a place this near to a limit may be beyond it, mm.
constexpr double kNear = 0.001;
/// So often the reach along the axis is halved.
constexpr int kHalvings = 30;

bool on_any_turn(const RotaryAxis& axis, double word) {
  if (!axis.present) return true;
  const double turn = 360.0 * std::ceil((axis.min - word) / 360.0);
  return !std::isfinite(turn) || word + turn <= axis.max;
}

/// The first limit that breaks, or is nearer than kNear, with each solution whose rotaries serve; empty where
/// one breaks none.
std::vector<std::string> broken_limits(const Pose& pose, const MachineModel& machine, const Setup& setup) {
  MachineModel narrower = machine;
  for (LinearAxis* axis : {&narrower.x, &narrower.y, &narrower.z}) axis->min += kNear, axis->max -= kNear;
  std::vector<std::string> broken;
  const auto solutions = inverse(machine, setup, pose, 0.0);
  if (!solutions) return broken;
  for (Joints words : *solutions) {
    if (!on_any_turn(machine.tilt, words.a) || !on_any_turn(machine.rotary, words.c)) continue;
    words.a = machine.tilt.present ? std::clamp(words.a, machine.tilt.min, machine.tilt.max) : words.a;
    words.c = machine.rotary.present ? std::clamp(words.c, machine.rotary.min, machine.rotary.max) : words.c;
    const auto near = broken_limit(narrower, words), limit = broken_limit(machine, words);
    if (!near) return {};
    broken.push_back(limit ? *limit : *near);
  }
  return broken;
}

std::optional<std::string> out_of_travel(const Pose& pose, const MachineModel& machine, const Setup& setup,
                                         double clear_height) {
  const Vec3 up = rotary_up(machine, setup);
  const Pose end = raised(pose, up, clear_height);
  const std::vector<std::string> broken = broken_limits(end, machine, setup);
  if (broken.empty() || !broken_limits(pose, machine, setup).empty()) return std::nullopt;
  double low = 0.0, high = distance(pose.tip, end.tip);
  for (int i = 0; i < kHalvings; ++i) {
    const double way = 0.5 * (low + high);
    const bool reached = broken_limits({pose.tip + pose.axis * way, pose.axis}, machine, setup).empty();
    (reached ? low : high) = way;
  }
  const std::string height = decimal(std::floor(dot(from_origin(pose.tip + pose.axis * low), up) - kRoom), 0);
  return "the tool leans by " + decimal(angle_between(pose.axis, up) * 180.0 / kPi, 1) +
         " degrees and must rise " + decimal(distance(pose.tip, end.tip), 1) +
         " mm along its axis to the clear height of " + decimal(clear_height, 3) + " mm, where " + broken[0] +
         "; within its travels it rises to " + height + " mm: state --clear-height " + height +
         " where nothing is higher, or leave it out to begin and end as the CL file does" +
         (part_zero_helps(limited_axis(broken[0]), end, machine, setup)
              ? ", or move the part on the table (post --part-zero)"
              : "");
}

}  // namespace

std::optional<std::string> out_of_travel_at_ends(const AptOperation& operation, const MachineModel& machine,
                                                 const Setup& setup, double clear_height) {
  const auto& moves = operation.path.moves;
  for (const std::size_t end : {std::size_t{0}, moves.size() - 1})
    if (const auto why = out_of_travel(moves[end].pose, machine, setup, clear_height))
      return std::to_string(operation.lines[end]) + ": " + *why;
  return std::nullopt;
}

AptOperation with_safe_approach(AptOperation operation, const MachineModel& machine, const Setup& setup,
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
