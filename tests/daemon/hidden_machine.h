#pragma once
// A machine that is not as its profile says, measured with a probe that is not exact: by the simulated
// machine's own chain of frames.

#include <cmath>
#include <random>
#include <vector>

#include "daemon/measure/ball_readings.h"
#include "sim/motion/forward.h"

namespace tiltfeed::daemon {

/// Where the gauge line's home puts the program's zero: X Y Z read there less the words.
inline Vec3 zero_offset(const MachineModel& m, double tool_length) {
  return from_origin(m.table_centre) + m.spindle * tool_length;
}

/// X Y Z that put the tip on `target` (part coordinates with part zero on the table's point), by the frames.
inline Vec3 axes_to(const MachineModel& m, const BallPlace& at, Vec3 target) {
  Setup setup;
  setup.tool_length = at.tool_length;
  const auto tip = [&](Vec3 q) {
    return from_origin(sim::forward_by_frames(m, setup, {q.x, q.y, q.z, at.tilt, at.rotary}).tip);
  };
  const Vec3 origin = tip({}), x = tip({1, 0, 0}) - origin, y = tip({0, 1, 0}) - origin,
             z = tip({0, 0, 1}) - origin, way = target - origin;
  return Vec3{dot(x, way), dot(y, way), dot(z, way)} + zero_offset(m, at.tool_length);
}

/// The profile with errors: every length up to `mm`, every angle up to `degrees`.
inline MachineModel hidden(MachineModel m, std::mt19937& random, double mm, double degrees) {
  const auto in = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  const auto shift = [&](Vec3 v) { return v + Vec3{in(mm), in(mm), in(mm)}; };
  const double lean = Angle::from_degrees(degrees).radians();
  const auto bend = [&](Vec3 v) { return normalized(v + Vec3{in(lean), in(lean), in(lean)}); };
  const Vec3 centre = shift({});
  m.table_centre = m.table_centre + centre;
  m.rotary.direction = bend(m.rotary.direction);
  m.tilt.direction = bend(m.tilt.direction);
  if (m.tilt.present) m.tilt.zero += in(degrees);
  if (m.structure == Structure::kHeadHead) m.rotary.zero += in(degrees);
  if (m.structure != Structure::kTableTable) m.pivot_to_gauge = shift(m.pivot_to_gauge);
  if (m.structure != Structure::kTableHead) m.rotary_to_tilt = shift(m.rotary_to_tilt);
  return m;
}

/// Nine touches: four at the ball's equator, four half-way up, one on top; noise along each.
inline std::vector<Vec3> touches_of(Vec3 centre, double radius, double noise, std::mt19937& random) {
  std::vector<Vec3> all;
  std::normal_distribution<double> off(0.0, noise);
  const double half = std::sqrt(0.5);
  for (const double up : {0.0, half})
    for (int i = 0; i < 4; ++i) {
      const double turn = kPi / 2 * (i + up), flat = std::sqrt(1.0 - up * up);
      all.push_back(Vec3{flat * std::cos(turn), flat * std::sin(turn), up});
    }
  all.push_back({0, 0, 1});
  for (Vec3& one : all) one = centre + one * (radius + (noise > 0 ? off(random) : 0.0));
  return all;
}

/// A ball at `ball` on the table (in the world for head-head) found at each place: centred, or touched.
inline BallReadings measured(const MachineModel& m, Vec3 ball, const std::vector<BallPlace>& places,
                             double noise, bool touches, std::mt19937& random) {
  BallReadings all;
  all.touches = touches;
  std::normal_distribution<double> off(0.0, noise);
  const auto one = [&] { return noise > 0 ? off(random) : 0.0; };
  for (const BallPlace& at : places) {
    const int place = static_cast<int>(all.places.size());
    const Vec3 centre = axes_to(m, at, ball);
    all.places.push_back(std::to_string(place + 1));
    if (!touches) {
      all.all.push_back({at, centre + Vec3{one(), one(), one()}, place, place + 2});
      continue;
    }
    for (const Vec3 axes : touches_of(centre, 12.5, noise, random)) all.all.push_back({at, axes, place, 0});
  }
  return all;
}

/// How far the tip of the hidden machine strays on the part, at random poses, while the words are those that
/// `model` gives for one point of the part.
inline double worst_tip(const MachineModel& hidden, const MachineModel& model, double tool_length, int poses,
                        std::mt19937& random, double most_tilt = 100.0, double side = 200.0) {
  const auto in = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto words = [&](const RotaryAxis& axis, double most) {
    return in(std::max(axis.min, axis.zero - most), std::min(axis.max, axis.zero + most));
  };
  Setup setup;
  setup.tool_length = tool_length;
  const Vec3 between = zero_offset(model, tool_length) - zero_offset(hidden, tool_length);
  const auto tip = [&](Point<Part> point, double a, double c) {
    Joints q = solve_linear(model, setup, point, a, c);
    q.x += between.x, q.y += between.y, q.z += between.z;
    return sim::forward_by_frames(hidden, setup, q).tip;
  };
  double worst = 0.0;
  for (int i = 0; i < poses; ++i) {
    const Point<Part> point{in(-side, side), in(-side, side), in(0, 300)};
    const Vec3 strayed = tip(point, words(model.tilt, most_tilt), words(model.rotary, 180.0)) -
                         tip(point, model.tilt.zero, model.rotary.zero);
    worst = std::max(worst, length(strayed));
  }
  return worst;
}

}  // namespace tiltfeed::daemon
