// Right-handed frames; a body's turn, sign (word - zero), is counter-clockwise seen from the tip of its
// axis's direction. Formulas: kinematics/machine/README.md.

#include "kinematics/machine/machine.h"

#include <cmath>

#include "kinematics/basics/decimal.h"
#include "kinematics/machine/chain.h"

namespace tiltfeed {
namespace {

double wrapped(double degrees) {
  const double turn = std::remainder(degrees, 360.0);
  return turn <= -180.0 ? 180.0 : turn;
}

std::optional<std::string> broken(const std::string& name, const char* unit, const char* what, double value,
                                  double min, double max) {
  const auto text = [&](const char* side, double limit) {
    const std::string found = decimal(value, 4), allowed = decimal(limit, 4);
    return name + (found == allowed ? " goes " : " " + found + " " + unit + " is ") + side + " its " + what +
           " of " + allowed + " " + unit;
  };
  if (!(value >= min)) return text("below", min);
  if (!(value <= max)) return text("above", max);
  return std::nullopt;
}

std::string axis_text(Vec3 axis) {
  return "tool axis (" + decimal(axis.x, 6) + ", " + decimal(axis.y, 6) + ", " + decimal(axis.z, 6) + ")";
}

std::string degrees(double radians) { return decimal(Angle::from_radians(radians).degrees(), 4); }

/// Why a machine that lacks a rotary axis, or both, does not give a tool axis.
std::string short_of_axes(const MachineModel& machine, const Chain& chain, Vec3 axis_P, Vec3 axis_T) {
  std::string has = "it has no rotary axis";
  for (const RotaryAxis* axis : {&machine.tilt, &machine.rotary})
    if (axis->present) has = std::string("of the rotary axes it has ") + axis->letter + " alone";
  return axis_text(axis_P) + " lies " + degrees(chain.solve_axis(axis_T).missed) +
         " degrees from the nearest that " + machine.name + " gives: " + has +
         "; turn the part (setup.fixture), or take a machine with more rotary axes";
}

bool inside(double value, double min, double max) { return value >= min && value <= max; }

}  // namespace

RotaryAxis absent_axis(Vec3 direction) {
  RotaryAxis axis;
  axis.letter = kNoLetter;
  axis.direction = direction;
  axis.velocity = axis.acceleration = 1e6;  // it never moves
  axis.present = false;
  return axis;
}

Pose forward(const MachineModel& machine, const Setup& setup, const Joints& joints) {
  const Chain chain(machine, setup);
  return chain.pose({joints.x, joints.y, joints.z}, Trig::of(chain.tilt_radians(joints.a)),
                    Trig::of(chain.rotary_radians(joints.c)));
}

Result<std::array<Joints, 2>> inverse(const MachineModel& machine, const Setup& setup, const Pose& pose,
                                      double c_at_pole) {
  const Chain chain(machine, setup);
  const Vec3 axis = chain.on_table(normalized(pose.axis));
  const AxisSolutions solved = chain.solve_axis(axis);
  if (solved.missed > 0.0) return fail(Code::kUnreachable, unreachable_text(machine, pose.axis, axis));
  std::array<Joints, 2> joints;
  for (std::size_t i = 0; i < 2; ++i) {
    const double c = solved.rotary_free ? c_at_pole : wrapped(chain.rotary_word(solved.angles[i].rotary));
    joints[i] = solve_linear(machine, setup, pose.tip, chain.tilt_word(solved.angles[i].tilt), c);
  }
  return joints;
}

Joints solve_linear(const MachineModel& machine, const Setup& setup, Point<Part> tip, double a, double c) {
  const Chain chain(machine, setup);
  const Vec3 p = chain.linear(tip, Trig::of(chain.tilt_radians(a)), Trig::of(chain.rotary_radians(c)));
  return {p.x, p.y, p.z, a, c};
}

double control_word(RotaryWord counting, double to, double from, int decimals) {
  if (counting == RotaryWord::kAccumulate) return to;
  const double place = round_decimal(to - 360.0 * std::floor(to / 360.0), decimals);
  return counting == RotaryWord::kSigned && to < from ? -place : place;
}

double counted_turn(RotaryWord counting, double word, double from) {
  if (counting == RotaryWord::kAccumulate) return word;
  double to = std::abs(word) + 360.0 * std::round((from - std::abs(word)) / 360.0);
  if (counting == RotaryWord::kShortest) return word + 360.0 * std::round((from - word) / 360.0);
  if (word >= 0.0 && to < from) to += 360.0;
  if (word < 0.0 && to > from) to -= 360.0;
  return to;
}

Vec3 rotary_up(const MachineModel& machine, const Setup& setup) {
  const Vec3 n = machine.rotary.direction;
  return transposed(setup.fixture) * (dot(n, machine.spindle) < 0.0 ? -n : n);
}

bool within_limits(const MachineModel& m, const Joints& q) {
  return inside(q.a, m.tilt.min, m.tilt.max) && inside(q.c, m.rotary.min, m.rotary.max) &&
         inside(q.x, m.x.min, m.x.max) && inside(q.y, m.y.min, m.y.max) && inside(q.z, m.z.min, m.z.max);
}

std::optional<std::string> broken_limit(const MachineModel& m, const Joints& q) {
  if (auto text = broken({m.tilt.letter}, "degrees", "limit", q.a, m.tilt.min, m.tilt.max)) return text;
  if (auto text = broken({m.rotary.letter}, "degrees", "limit", q.c, m.rotary.min, m.rotary.max)) return text;
  if (auto text = broken("X", "mm", "travel", q.x, m.x.min, m.x.max)) return text;
  if (auto text = broken("Y", "mm", "travel", q.y, m.y.min, m.y.max)) return text;
  return broken("Z", "mm", "travel", q.z, m.z.min, m.z.max);
}

std::string unreachable_text(const MachineModel& machine, Vec3 axis_P, Vec3 axis_T) {
  const Chain chain(machine, {});
  if (!machine.tilt.present || !machine.rotary.present) return short_of_axes(machine, chain, axis_P, axis_T);
  const auto [least, greatest] = chain.reach();
  const double off = chain.off_rotary(axis_T);
  return axis_text(axis_P) + " lies " + degrees(off) + " degrees from the axis of " + machine.rotary.letter +
         "; " + machine.tilt.letter + " of " + machine.name + " reaches " + degrees(least) + " to " +
         degrees(greatest) + " degrees: " +
         (off < least ? "allow a larger axis tolerance or tilt the part (setup.fixture)"
                      : "tilt the tool less or turn the part on the table");
}

}  // namespace tiltfeed
