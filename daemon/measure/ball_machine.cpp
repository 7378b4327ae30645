// Right-handed; a body's turn, sign (word - zero), is counter-clockwise seen from the tip of its direction.

#include "daemon/measure/ball_machine.h"

#include <array>

namespace tiltfeed::daemon {
namespace {

double turn_of(const RotaryAxis& axis, double word) {
  return axis.present ? Angle::from_degrees(axis.sign * (word - axis.zero)).radians() : 0.0;
}

/// Two unit vectors square to `n` and to each other.
std::array<Vec3, 2> tangents(Vec3 n) {
  const Vec3 other = std::abs(n.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 first = normalized(other - n * dot(n, other));
  return {first, cross(n, first)};
}

double& component(Vec3& v, int part) { return part == 0 ? v.x : part == 1 ? v.y : v.z; }

void lean(Vec3& direction, int part, double angle) {
  direction = normalized(direction + tangents(direction)[static_cast<std::size_t>(part)] * angle);
}

/// How far to turn `from` about `n` so that it lies in the half plane of `to`, rad.
double azimuth_to(Vec3 n, Vec3 from, Vec3 to) {
  return std::atan2(dot(n, cross(from, to)), dot(from, to) - dot(n, from) * dot(n, to));
}

/// The direction near `before` that leans by `angle` to `n`, in the half plane of n and `before`.
Vec3 leaning_by(Vec3 n, Vec3 before, double angle) {
  return n * std::cos(angle) + normalized(before - n * dot(n, before)) * std::sin(angle);
}

/// The shift along `n` after which `point` is as far along `axis` as `before`.
Vec3 back_along(Vec3 n, Vec3 axis, Vec3 point, Vec3 before) {
  return n * (dot(before - point, axis) / dot(n, axis));
}

Vec3 centre_of(const MachineModel& m) { return from_origin(m.table_centre); }
void set_centre(MachineModel& m, Vec3 c) { m.table_centre = {c.x, c.y, c.z}; }

void keep_sign(RotaryAxis& axis, const RotaryAxis& before) {
  if (dot(axis.direction, before.direction) >= 0.0) return;
  axis.direction = -axis.direction;
  axis.sign = -axis.sign;
}

/// Another word as home: all that the axis carries, turned on by `angle`.
void move_home(RotaryAxis& axis, double angle) {
  axis.zero += axis.sign * Angle::from_radians(angle).degrees();
}

/// What the gauge line's way to the pivot is changed by, the table's point makes up for: no reading changes.
void set_gauge(MachineModel& m, Vec3 gauge) {
  if (m.structure == Structure::kTableHead) set_centre(m, centre_of(m) + m.pivot_to_gauge - gauge);
  m.pivot_to_gauge = gauge;
}

/// Another spindle direction; the tip of a tool of this length stays where it is.
void set_spindle(MachineModel& m, Vec3 spindle, double tool_length) {
  const Vec3 change = (spindle - m.spindle) * tool_length;
  m.spindle = spindle;
  if (m.structure != Structure::kTableTable && m.tilt.present) return set_gauge(m, m.pivot_to_gauge + change);
  set_centre(m, centre_of(m) - change);
}

void settle_homes(MachineModel& m, const MachineModel& before, bool spindle) {
  if (m.structure == Structure::kTableTable) {
    const Vec3 n = m.tilt.direction, pivot = centre_of(m) + m.rotary_to_tilt;
    const double angle = azimuth_to(n, m.rotary.direction, before.rotary.direction);
    const Rotation turn = rotation_about(n, angle);
    m.rotary.direction = turn * m.rotary.direction;
    m.rotary_to_tilt = turn * m.rotary_to_tilt;
    set_centre(m, pivot - m.rotary_to_tilt);
    move_home(m.tilt, angle);
  }
  if (m.structure == Structure::kHeadHead) {
    const double angle = azimuth_to(m.rotary.direction, m.tilt.direction, before.tilt.direction);
    const Rotation turn = rotation_about(m.rotary.direction, angle);
    for (Vec3* v : {&m.tilt.direction, &m.rotary_to_tilt, &m.pivot_to_gauge, &m.spindle}) *v = turn * *v;
    move_home(m.rotary, angle);
  }
  if (m.structure != Structure::kTableTable && m.tilt.present && spindle) {
    const double angle = azimuth_to(m.tilt.direction, m.spindle, before.spindle);
    const Rotation turn = rotation_about(m.tilt.direction, angle);
    m.spindle = turn * m.spindle;
    set_gauge(m, turn * m.pivot_to_gauge);
    move_home(m.tilt, angle);
  }
}

/// Points anywhere on an axis serve: those of before.
void settle_points(MachineModel& m, const MachineModel& before) {
  const Vec3 nC = m.rotary.direction, nT = m.tilt.direction;
  const Vec3 nC0 = before.rotary.direction, nT0 = before.tilt.direction;
  if (m.structure == Structure::kHeadHead) {
    const Vec3 along = back_along(nT, nT0, m.pivot_to_gauge, before.pivot_to_gauge);
    m.pivot_to_gauge = m.pivot_to_gauge + along;
    m.rotary_to_tilt = m.rotary_to_tilt - along;
    m.rotary_to_tilt = m.rotary_to_tilt + back_along(nC, nC0, m.rotary_to_tilt, before.rotary_to_tilt);
    return;
  }
  // A pivot that is said to lie elsewhere on its axis moves no reading, hence no table point.
  if (m.structure == Structure::kTableHead && m.tilt.present)
    m.pivot_to_gauge = m.pivot_to_gauge + back_along(nT, nT0, m.pivot_to_gauge, before.pivot_to_gauge);
  if (!m.rotary.present) return;
  const Vec3 along = back_along(nC, nC0, centre_of(m), centre_of(before));
  set_centre(m, centre_of(m) + along);
  if (m.structure != Structure::kTableTable) return;
  m.rotary_to_tilt = m.rotary_to_tilt - along;
  m.rotary_to_tilt = m.rotary_to_tilt + back_along(nT, nT0, m.rotary_to_tilt, before.rotary_to_tilt);
}

std::vector<double> parts_of(Vec3 v) { return {v.x, v.y, v.z}; }

std::vector<double> angles_from(Vec3 direction, Vec3 before) {
  std::vector<double> parts;
  for (const Vec3 t : tangents(before)) parts.push_back(Angle::from_radians(dot(direction, t)).degrees());
  return parts;
}

}  // namespace

Vec3 reading_at(const BallMachine& machine, const BallPlace& place) {
  const MachineModel& m = machine.machine;
  const Rotation rotary = rotation_about(m.rotary.direction, turn_of(m.rotary, place.rotary));
  const Rotation tilt = rotation_about(m.tilt.direction, turn_of(m.tilt, place.tilt));
  const Vec3 g = m.pivot_to_gauge, d = m.rotary_to_tilt, tool = m.spindle * place.tool_length;
  switch (m.structure) {
    case Structure::kTableTable:
      return centre_of(m) + d + tool + tilt * (rotary * machine.ball - d);
    case Structure::kHeadHead:
      return machine.ball + d + g - rotary * (d + tilt * (g - tool));
    case Structure::kTableHead:
      break;
  }
  return centre_of(m) + g + rotary * machine.ball - tilt * (g - tool);
}

std::vector<Unknown> unknowns_of(const MachineModel& m, bool spindle, bool touches) {
  std::vector<Unknown> all;
  const auto add = [&](Sought what, int parts) {
    for (int i = 0; i < parts; ++i) all.push_back({what, i});
  };
  const bool head_head = m.structure == Structure::kHeadHead;
  if (!head_head) add(Sought::kCentre, 3);
  if (m.rotary.present) {
    add(Sought::kRotary, 2);
    add(Sought::kBall, 3);
  }
  if (m.tilt.present) {
    add(Sought::kTilt, 2);
    if (m.structure != Structure::kTableTable) add(Sought::kGauge, 3);
  }
  if (m.structure != Structure::kTableHead) add(Sought::kOffset, 3);
  if (spindle) add(Sought::kSpindle, 2);
  if (touches) add(Sought::kRadius, 1);
  return all;
}

int gauges_of(const MachineModel& m) { return (m.rotary.present ? 1 : 0) + (m.tilt.present ? 1 : 0); }

BallMachine moved(BallMachine machine, Unknown unknown, double step) {
  MachineModel& m = machine.machine;
  const auto [what, part] = unknown;
  switch (what) {
    case Sought::kCentre: {
      Vec3 centre = centre_of(m);
      component(centre, part) += step;
      set_centre(m, centre);
      break;
    }
    case Sought::kRotary:
      lean(m.rotary.direction, part, step / kLever);
      break;
    case Sought::kBall:
      component(machine.ball, part) += step;
      break;
    case Sought::kTilt:
      lean(m.tilt.direction, part, step / kLever);
      break;
    case Sought::kGauge:
      component(m.pivot_to_gauge, part) += step;
      break;
    case Sought::kOffset:
      component(m.rotary_to_tilt, part) += step;
      break;
    case Sought::kSpindle:
      lean(m.spindle, part, step / kLever);
      break;
    case Sought::kRadius:
      machine.radius += step;
      break;
    case Sought::kTiltZero:
      m.tilt.zero += Angle::from_radians(step / kLever).degrees();
      break;
  }
  return machine;
}

MachineModel settled(const BallMachine& found, const MachineModel& before, bool spindle, double tool_length) {
  MachineModel m = found.machine;
  keep_sign(m.rotary, before.rotary);
  keep_sign(m.tilt, before.tilt);
  settle_homes(m, before, spindle);
  if (!spindle) {
    Vec3 leaning = before.spindle;
    if (m.tilt.present && m.rotary.present) {
      const Vec3 n = m.tilt.direction;
      const double beyond = angle_between(before.tilt.direction, before.spindle) -
                            angle_between(before.tilt.direction, before.rotary.direction);
      leaning = leaning_by(n, before.spindle, angle_between(n, m.rotary.direction) + beyond);
    }
    set_spindle(m, leaning, tool_length);
  }
  settle_points(m, before);
  return m;
}

std::vector<MeasuredValue> measured_values(const MachineModel& m, const MachineModel& before, bool spindle) {
  std::vector<MeasuredValue> all;
  const bool tilts = m.tilt.present, turns = m.rotary.present;
  const bool table = m.structure != Structure::kHeadHead;
  if (turns)
    all.push_back({"rotary.direction", "deg", angles_from(m.rotary.direction, before.rotary.direction)});
  if (turns && table) all.push_back({"table_centre_mm", "mm", parts_of(centre_of(m))});
  if (!table) all.push_back({"rotary.zero_deg", "deg", {m.rotary.zero}});
  if (tilts) all.push_back({"tilt.direction", "deg", angles_from(m.tilt.direction, before.tilt.direction)});
  if (tilts && (m.structure == Structure::kTableTable || spindle))
    all.push_back({"tilt.zero_deg", "deg", {m.tilt.zero}});
  if (tilts && m.structure != Structure::kTableTable)
    all.push_back({"pivot_to_gauge_mm", "mm", parts_of(m.pivot_to_gauge)});
  if (m.structure != Structure::kTableHead)
    all.push_back({"rotary_to_tilt_mm", "mm", parts_of(m.rotary_to_tilt)});
  if (spindle || (tilts && turns))
    all.push_back({"spindle_direction", "deg", angles_from(m.spindle, before.spindle)});
  if (tilts && turns)
    all.push_back({"square",
                   "deg",
                   {Angle::from_radians(angle_between(m.tilt.direction, m.rotary.direction)).degrees()}});
  return all;
}

}  // namespace tiltfeed::daemon
