#include "kinematics/joints/joint_errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "kinematics/basics/decimal.h"

namespace tiltfeed {
namespace {

// A tool axis of a path is unit to this.
constexpr double kUnit = 1e-9;

std::string place(std::size_t index, const Pose& pose) {
  const auto triple = [](double x, double y, double z, int decimals) {
    return "(" + decimal(x, decimals) + ", " + decimal(y, decimals) + ", " + decimal(z, decimals) + ")";
  };
  return "move " + std::to_string(index) + ", tip " + triple(pose.tip.x, pose.tip.y, pose.tip.z, 4) +
         ", axis " + triple(pose.axis.x, pose.axis.y, pose.axis.z, 6) + ": ";
}

bool opposite(Vec3 u, Vec3 v) { return dot(u, v) < 0.0 && angle_between(u, v) > kPi - kOpposite; }

/// Whether another set-up moves the words of the linear axis at this pose by more than it moves the part.
bool moves_word(char letter, const Pose& pose, const MachineModel& machine, const Setup& setup,
                const Setup& other) {
  constexpr double kMoved = 1e-6;  // of 1 mm
  const auto solutions = inverse(machine, setup, pose, 0.0);
  if (!solutions) return true;
  double Joints::*const word = letter == 'X' ? &Joints::x : (letter == 'Y' ? &Joints::y : &Joints::z);
  return std::any_of(solutions->begin(), solutions->end(), [&](const Joints& at) {
    const Joints now = solve_linear(machine, setup, pose.tip, at.a, at.c),
                 then = solve_linear(machine, other, pose.tip, at.a, at.c);
    return std::abs(then.*word - now.*word) > kMoved;
  });
}

/// What moves the word of a linear axis at this pose: words count from the part, so that moving it on the
/// table does so only where a rotary has turned it, and the tool's length only where a head leans.
std::string travel_remedy(char letter, const Pose& pose, const MachineModel& machine, const Setup& setup) {
  Setup longer = setup;
  longer.tool_length += 1.0;
  std::string text;
  if (part_zero_helps(letter, pose, machine, setup))
    text += "move the part on the table (setup.part_zero_mm, post --part-zero), ";
  if (moves_word(letter, pose, machine, setup, longer)) text += "change the tool's length, ";
  if (!text.empty()) text += "or ";
  return "; " + text + "state the profile's travels as the words from this work offset count";
}

/// Whether the rotaries give this axis within their limits, with the table some whole turns on.
bool rotaries_give(const Pose& pose, const MachineModel& machine, const Setup& setup) {
  const auto solutions = inverse(machine, setup, pose, 0.0);
  if (!solutions) return false;
  return std::any_of(solutions->begin(), solutions->end(), [&](const Joints& at) {
    const double least = at.c + 360.0 * std::ceil((machine.rotary.min - at.c) / 360.0);
    return least <= machine.rotary.max && at.a >= machine.tilt.min && at.a <= machine.tilt.max;
  });
}

/// What to change for a broken limit; nothing for other messages.
std::string remedy(const MachineModel& machine, const Setup& setup, const Pose& pose,
                   const std::string& text) {
  const char letter = limited_axis(text);
  if (letter == '\0') return {};
  const bool unwinds = letter == machine.rotary.letter && rotaries_give(pose, machine, setup);
  if (letter == machine.tilt.letter || (letter == machine.rotary.letter && !unwinds))
    return "; tilt the tool less, or turn the part on the table (setup.fixture_rotation_deg, post --fixture)";
  if (unwinds)
    return "; cut to and fro (zigzag) or in shorter runs so that the table unwinds, or let the tool be taken "
           "off "
           "in between (post --clear-height, --clear-radius)";
  return travel_remedy(letter, pose, machine, setup);
}

}  // namespace

bool part_zero_helps(char letter, const Pose& pose, const MachineModel& machine, const Setup& setup) {
  Setup moved = setup;
  moved.part_zero = setup.part_zero + Vec3{1.0, 1.3, 1.7};
  return moves_word(letter, pose, machine, setup, moved);
}

char limited_axis(const std::string& text) { return text.size() > 1 && text[1] == ' ' ? text.front() : '\0'; }

Error located(const Error& error, std::size_t index, const Pose& pose, const MachineModel& machine,
              const Setup& setup) {
  return {error.code, place(index, pose) + error.message + remedy(machine, setup, pose, error.message)};
}

Result<void> check_path(const ToolPath& path, const MachineModel& machine, const JointPathOptions& options) {
  assert(options.tolerance > 0.0 && options.axis_tolerance > 0.0);
  if (path.moves.empty()) return fail(Code::kInput, "tool path " + path.name + " has no moves");
  if (path.moves.size() > 0xFFFFFFFFu) return fail(Code::kInput, "tool path has more than 2^32 moves");
  for (const double velocity : {machine.x.velocity, machine.y.velocity, machine.z.velocity,
                                machine.tilt.velocity, machine.rotary.velocity}) {
    if (!(velocity > 0.0))
      return fail(Code::kInput, "machine " + machine.name + ": an axis velocity is " + decimal(velocity, 4) +
                                    "; state one above 0 for every axis");
  }
  for (std::size_t i = 0; i < path.moves.size(); ++i) {
    const Move& move = path.moves[i];
    if (!is_finite(move.pose.tip) || !(std::abs(length(move.pose.axis) - 1.0) < kUnit))
      return fail(Code::kInput, place(i, move.pose) + "the tip must be finite and the axis of length 1");
    const Feed feed = feed_of(path, i);
    if (move.kind != MoveKind::kRapid && !(feed.mm_per_min() > 0.0))
      return fail(Code::kInput, place(i, move.pose) + "its feed is " + decimal(feed.mm_per_min(), 4) +
                                    " mm/min; state one above 0");
    if (i > 0 && opposite(move.pose.axis, path.moves[i - 1].pose.axis))
      return fail(Code::kInput,
                  place(i, move.pose) + "the axis turns over by 180 degrees in one move; give it a way");
  }
  return {};
}

bool turns_over(const ToolPath& path) {
  for (std::size_t i = 1; i < path.moves.size(); ++i)
    if (opposite(path.moves[i - 1].pose.axis, path.moves[i].pose.axis)) return true;
  return false;
}

}  // namespace tiltfeed
