#include "sim/collision/machine_line.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

/// A rotation that takes +z to `axis`.
Rotation upright_to(Vec3 axis) {
  const Vec3 side = std::abs(axis.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 y = normalized(cross(axis, side)), x = cross(y, axis);
  return transposed(Rotation{{x, y, axis}});
}

}  // namespace

MachineLine::MachineLine(const config::MachineProfile& machine, const Setup& setup)
    : structure_(machine.model.structure),
      centre_(from_origin(machine.model.table_centre)),
      zero_(centre_ + setup.part_zero),
      gauge_to_tip_(machine.model.spindle * -setup.tool_length),
      spindle_(machine.model.spindle),
      fixture_(setup.fixture) {
  const MachineModel& model = machine.model;
  // With the rotaries at home and all words 0 the tip is at part zero; at machine zero the gauge line is
  // there.
  home_ = gauge_to_tip_ - zero_;
  const Vec3 pivot = -model.pivot_to_gauge;
  if (structure_ != Structure::kHeadHead) add_rotary(model.rotary, kRotaryAxis, centre_, true);
  if (structure_ == Structure::kTableTable)
    add_rotary(model.tilt, kTiltAxis, centre_ + model.rotary_to_tilt, true);
  std::vector<int> inward = machine.solid.work_slides;
  std::reverse(inward.begin(), inward.end());
  add_slides(inward, true);
  bed_ = tool();
  add_slides(machine.solid.tool_slides, false);
  if (structure_ == Structure::kHeadHead)
    add_rotary(model.rotary, kRotaryAxis, pivot - model.rotary_to_tilt, false);
  if (structure_ != Structure::kTableTable) add_rotary(model.tilt, kTiltAxis, pivot, false);
}

void MachineLine::add_slides(const std::vector<int>& axes, bool work) {
  constexpr std::array<Vec3, 3> kAlong{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (const int axis : axes) {
    const auto at = static_cast<std::size_t>(axis);
    slide_link_[at] = work ? tool() : tool() + 1;
    joints_.push_back({at, {}, kAlong[at], 1.0, dot(home_, kAlong[at])});
  }
}

void MachineLine::add_rotary(const RotaryAxis& axis, std::size_t index, Vec3 point, bool work) {
  if (!axis.present) return;
  joints_.push_back({index, point, axis.direction, work ? -axis.sign * 1.0 : axis.sign * 1.0, axis.zero});
}

int MachineLine::link(config::BodyLink body) const {
  using config::BodyLink;
  switch (body) {
    case BodyLink::kBed:
      return bed_;
    case BodyLink::kXSlide:
      return slide_link_[0];
    case BodyLink::kYSlide:
      return slide_link_[1];
    case BodyLink::kZSlide:
      return slide_link_[2];
    case BodyLink::kTable:
      return work();
    case BodyLink::kCradle:
      return work() + 1;
    case BodyLink::kFork:
      return tool() - 1;
    case BodyLink::kHead:
    case BodyLink::kNose:
      break;
  }
  return tool();
}

Vec3 MachineLine::origin(config::BodyLink body) const {
  return body == config::BodyLink::kTable || body == config::BodyLink::kCradle ? centre_ : Vec3{};
}

Placement MachineLine::tip() const { return {upright_to(spindle_), gauge_to_tip_}; }

Placement MachineLine::relative(const AxisWords& words, int from, int to) const {
  Placement all;
  for (int k = from; k < to; ++k) {
    const LineJoint& joint = joints_[static_cast<std::size_t>(k)];
    const double by = joint.factor * (words[joint.axis] - joint.home);
    if (!joint.turns()) {
      all.shift = all.shift + all.rotation * (joint.direction * by);
      continue;
    }
    const Rotation turn = rotation_about(joint.direction, Angle::from_degrees(by).radians());
    all = all * Placement{turn, joint.point - turn * joint.point};
  }
  return all;
}

}  // namespace tiltfeed::sim
