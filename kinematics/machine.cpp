// Right-handed frames; phi = rotary.sign (C - C0) and alpha = tilt.sign (A - A0) are counter-clockwise seen
// from the tip of the axis's direction. Formulas: kinematics/README.md.

#include "kinematics/machine.h"

#include "kinematics/chain.h"
#include "kinematics/decimal.h"

namespace tiltfeed {
namespace {

double wrapped(double degrees) {
  const double turn = std::remainder(degrees, 360.0);
  return turn <= -180.0 ? 180.0 : turn;
}

std::optional<std::string> broken(const std::string& name, const char* unit, const char* what, double value,
                                  double min, double max) {
  const auto text = [&](const char* side, double limit) {
    return name + " " + decimal(value, 4) + " " + unit + " is " + side + " its " + what + " of " +
           decimal(limit, 4) + " " + unit;
  };
  if (!(value >= min)) return text("below", min);
  if (!(value <= max)) return text("above", max);
  return std::nullopt;
}

bool inside(double value, double min, double max) { return value >= min && value <= max; }

}  // namespace

Pose forward(const MachineModel& machine, const Setup& setup, const Joints& joints) {
  const Chain chain(machine, setup);
  return chain.pose({joints.x, joints.y, joints.z}, Trig::of(chain.head_radians(joints.a)),
                    Trig::of(chain.table_radians(joints.c)));
}

Result<std::array<Joints, 2>> inverse(const MachineModel& machine, const Setup& setup, const Pose& pose,
                                      double c_at_pole) {
  const Chain chain(machine, setup);
  const Vec3 axis = chain.on_table(normalized(pose.axis));
  const AxisSolutions solved = chain.solve_axis(axis);
  if (!solved.reachable) return fail(Code::kUnreachable, unreachable_text(machine, pose.axis, axis));
  std::array<Joints, 2> joints;
  for (std::size_t i = 0; i < 2; ++i) {
    const double c = solved.table_free ? c_at_pole : wrapped(chain.table_word(solved.angles[i].table));
    joints[i] = solve_linear(machine, setup, pose.tip, chain.head_word(solved.angles[i].head), c);
  }
  return joints;
}

Joints solve_linear(const MachineModel& machine, const Setup& setup, Point<Part> tip, double a, double c) {
  const Chain chain(machine, setup);
  const Vec3 p = chain.linear(tip, Trig::of(chain.head_radians(a)), Trig::of(chain.table_radians(c)));
  return {p.x, p.y, p.z, a, c};
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
  const double tilt = angle_between(axis_T, {0.0, 0.0, 1.0});
  return "tool axis (" + decimal(axis_P.x, 6) + ", " + decimal(axis_P.y, 6) + ", " + decimal(axis_P.z, 6) +
         ") lies " + decimal(Angle::from_radians(tilt).degrees(), 4) +
         " degrees from the table's axis; the head of " + machine.name + " reaches 0 to " +
         decimal(Angle::from_radians(Chain(machine, {}).reach()).degrees(), 4) +
         " degrees: tilt the tool less or turn the part on the table";
}

}  // namespace tiltfeed
