#include "pathgen/suggest/mounting.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kinematics/basics/units.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::pathgen {

namespace {

/// Another way of turning must gain so much of the area.
constexpr double kWorthTurning = 0.005;
/// Of a head's body, of which a profile says nothing: this far round its pivot and gauge line, mm.
constexpr double kHeadRadius = 100.0;
/// Heights over the table are multiples of this, mm.
constexpr double kHeightStep = 10.0;

Rotation turned(Vec3 degrees) {
  const auto about = [](Vec3 axis, double by) {
    return rotation_about(axis, Angle::from_degrees(by).radians());
  };
  return about({0, 0, 1}, degrees.z) * about({0, 1, 0}, degrees.y) * about({1, 0, 0}, degrees.x);
}

/// The turn that brings a direction of the part to the table's z.
Vec3 upright(Vec3 d) {
  const double x = std::atan2(d.y, d.z), y = std::atan2(-d.x, std::hypot(d.y, d.z));
  return {Angle::from_radians(x).degrees(), Angle::from_radians(y).degrees(), 0.0};
}

bool reached(const MachineReach& reach, const CutPose& p) {
  if (reach.refusal(p.pose)) return false;
  return p.back == 0.0 || !reach.refusal({p.pose.tip + p.pose.axis * p.back, p.pose.axis});
}

double area_reached(const MachineReach& reach, std::span<const CutPose> poses) {
  constexpr std::size_t kPosesAsked = 300;
  const std::size_t step = std::max<std::size_t>(1, poses.size() / kPosesAsked);
  double area = 0.0, all = 0.0, whole = 0.0;
  for (const CutPose& p : poses) whole += p.area;
  for (std::size_t i = 0; i < poses.size(); i += step) {
    all += poses[i].area;
    if (reached(reach, poses[i])) area += poses[i].area;
  }
  return all > 0.0 ? area / all * whole : 0.0;
}

}  // namespace

Mounting::Mounting(const MachineModel* machine, const Box& bounds, double tool_length)
    : machine_(machine),
      bounds_(bounds),
      tool_length_(tool_length),
      tilt_max_(machine != nullptr ? tilt_limit(*machine) : Angle::from_degrees(180.0)) {
  const bool table_turns = machine == nullptr || (machine->rotary.present && machine->tilt.present &&
                                                  std::abs(machine->rotary.direction.z) > 0.999);
  for (const double z : {0.0, 90.0, 180.0, 270.0}) {
    for (const Vec3 up :
         {Vec3{0, 0, 1}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 0, -1}}) {
      const Vec3 way = upright(up);
      quarters_.push_back({way.x, way.y, z});
    }
    if (table_turns) break;  // the table turns about z itself
  }
}

std::optional<MachineReach> Mounting::reach(const Setup& setup) const {
  if (machine_ == nullptr) return std::nullopt;
  return MachineReach(*machine_, setup, tilt_max_);
}

Setup Mounting::setup(Vec3 fixture_deg, std::optional<Point<Part>> on_axis) const {
  Setup setup;
  setup.fixture = turned(fixture_deg);
  setup.tool_length = tool_length_;
  const Vec3 middle = setup.fixture * from_origin(on_axis.value_or(lerp(bounds_.min, bounds_.max, 0.5)));
  double lowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 8; ++i)
    lowest = std::min(lowest, (setup.fixture * Vec3{i & 1 ? bounds_.max.x : bounds_.min.x,
                                                    i & 2 ? bounds_.max.y : bounds_.min.y,
                                                    i & 4 ? bounds_.max.z : bounds_.min.z})
                                  .z);
  const auto round = [](double v) { return std::round(v * 100.0) / 100.0 + 0.0; };
  setup.part_zero = {round(-middle.x), round(-middle.y), round(-lowest)};
  if (machine_ != nullptr && std::abs(machine_->rotary.direction.z) < 0.5 && machine_->rotary.present)
    setup.part_zero.z = round(-middle.z);  // a lying rotary table: the part is on its axis
  return setup;
}

Mounted Mounting::best(std::span<const CutPose> poses, std::optional<Vec3> axis,
                       std::optional<Point<Part>> on_axis) const {
  double whole = 0.0;
  for (const CutPose& p : poses) whole += p.area;
  if (machine_ == nullptr) return {setup({}, on_axis), {}, whole};
  std::vector<Vec3> ways = quarters_;
  if (axis)
    for (const double side : {1.0, -1.0}) ways.push_back(upright(*axis * side));
  Mounted best;
  for (const Vec3 way : ways) {
    const Setup mounted = setup(way, on_axis);
    const double area = area_reached(*reach(mounted), poses);
    if (area > best.area + (best.area > 0.0 ? kWorthTurning * whole : 0.0) || best.setup.tool_length == 0.0)
      best = {mounted, way, area};
  }
  return best;
}

Setup Mounting::raised(const Setup& setup, std::span<const CutPose> poses) const {
  if (machine_ == nullptr || machine_->structure == Structure::kTableTable || !machine_->tilt.present)
    return setup;
  const Vec3 up = machine_->rotary.present ? machine_->rotary.direction : Vec3{0, 0, 1};
  if (std::abs(up.z) < 0.999) return setup;
  const double lever = tool_length_ + length(machine_->pivot_to_gauge);
  const MachineReach within = *reach(setup);
  double lowest = std::numeric_limits<double>::infinity();
  for (const CutPose& p : poses) {
    if (!reached(within, p)) continue;
    const Vec3 tip = setup.fixture * from_origin(p.pose.tip), axis = setup.fixture * p.pose.axis;
    if (axis.z > 0.5) continue;  // the head stands well above
    lowest = std::min(lowest, tip.z + setup.part_zero.z + std::min(0.0, lever * axis.z) - kHeadRadius);
  }
  Setup raised = setup;
  if (lowest < 0.0) raised.part_zero.z += std::ceil(-lowest / kHeightStep) * kHeightStep;
  return raised;
}

}  // namespace tiltfeed::pathgen
