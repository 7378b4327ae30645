#include "sim/control/move_frames.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

double turned(double from, double to) { return std::abs(Angle::from_degrees(to - from).radians()); }

}  // namespace

MoveFrames::MoveFrames(const MachineModel& machine, const Setup& setup)
    : chain_(machine, setup),
      structure_(machine.structure),
      fixture_(setup.fixture),
      part_zero_(setup.part_zero),
      rotary_(machine.rotary.direction),
      pivot_to_tip_(length(machine.pivot_to_gauge + machine.spindle * -setup.tool_length)),
      between_(length(machine.rotary_to_tilt)) {}

Pose MoveFrames::pose(const Joints& words, bool tcp) const {
  const Pose joints = chain_(words);
  if (!tcp) return joints;
  return {Point<Part>{} + transposed(fixture_) * Vec3{words.x, words.y, words.z}, joints.axis};
}

Pose MoveFrames::pose(const ProgramMove& move, double share) const {
  const Joints &p = move.from, &q = move.to;
  return pose({p.x + share * (q.x - p.x), p.y + share * (q.y - p.y), p.z + share * (q.z - p.z),
               p.a + share * (q.a - p.a), p.c + share * (q.c - p.c)},
              move.tcp);
}

Joints MoveFrames::tip_words(const Joints& slides) const {
  const Vec3 tip = fixture_ * from_origin(chain_(slides).tip);
  return {tip.x, tip.y, tip.z, slides.a, slides.c};
}

Joints MoveFrames::slide_words(const Joints& tip) const {
  // With the rotaries as they are the tip follows the slides along three directions square to each other.
  const Point<Part> none = chain_({0.0, 0.0, 0.0, tip.a, tip.c}).tip;
  const Vec3 way = pose(tip, true).tip - none;
  return {dot(way, chain_({1.0, 0.0, 0.0, tip.a, tip.c}).tip - none),
          dot(way, chain_({0.0, 1.0, 0.0, tip.a, tip.c}).tip - none),
          dot(way, chain_({0.0, 0.0, 1.0, tip.a, tip.c}).tip - none), tip.a, tip.c};
}

Rotation MoveFrames::slides(const Joints& words) const {
  const Point<Part> none = chain_({0.0, 0.0, 0.0, words.a, words.c}).tip;
  const auto way = [&](double x, double y, double z) {
    return fixture_ * (chain_({x, y, z, words.a, words.c}).tip - none);
  };
  return transposed(Rotation{{way(1.0, 0.0, 0.0), way(0.0, 1.0, 0.0), way(0.0, 0.0, 1.0)}});
}

MoveFrames::Bounds MoveFrames::bounds(const ProgramMove& move, const Pose& from, const Pose& to,
                                      double reach) const {
  const Joints &p = move.from, &q = move.to;
  const double a = turned(p.a, q.a), c = turned(p.c, q.c);
  if (move.tcp) return {(a + c) * (a + c) * reach, (a + c) * (a + c) * (a + c) * reach};
  const double slides = std::hypot(q.x - p.x, q.y - p.y, q.z - p.z), arm = pivot_to_tip_ + reach;
  // What the rotary turns: how far from its axis it is, and bounds of its own derivatives.
  const auto turning = [c](double far, double first, double second, double third) -> Bounds {
    return {c * c * far + 2.0 * c * first + second,
            c * c * c * far + 3.0 * c * c * first + 3.0 * c * second + third};
  };
  if (structure_ == Structure::kHeadHead)
    return turning(between_ + arm, a * arm, a * a * arm, a * a * a * arm);
  const auto from_axis = [&](const Pose& pose) {
    const Vec3 tip = fixture_ * from_origin(pose.tip) + part_zero_;
    return length(tip - rotary_ * dot(tip, rotary_));
  };
  const double table = std::max(from_axis(from), from_axis(to)) + reach;
  if (structure_ == Structure::kTableHead) {
    const double way = slides + a * arm;
    return turning(table + way, way, a * a * arm, a * a * a * arm);
  }
  const auto from_tilt = [&](const Pose& pose) {
    return length(fixture_ * from_origin(pose.tip) + part_zero_) + between_;
  };
  const double tilted = std::max(from_tilt(from), from_tilt(to)) + reach + slides;
  const double way = slides + a * tilted;
  return turning(table + way, way, a * a * tilted + 2.0 * a * slides,
                 a * a * a * tilted + 3.0 * a * a * slides);
}

double MoveFrames::stray(const ProgramMove& move, const Pose& from, const Pose& middle, const Pose& to,
                         double reach) const {
  if (!turns(move)) return 0.0;
  const Bounds most = bounds(move, from, to, reach);
  // A curve leaves its chord by no more than an eighth of its largest second derivative. That is eight times
  // what it leaves it half way, but for half of the third.
  const Vec3 tip = (from.tip - middle.tip) + (to.tip - middle.tip),
             axis = from.axis + to.axis - middle.axis * 2.0;
  const double half_way = 0.5 * (length(tip) + reach * length(axis));
  return std::min(most.second / 8.0, half_way + most.third / 16.0);
}

}  // namespace tiltfeed::sim
