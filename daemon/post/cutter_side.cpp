#include "daemon/post/cutter_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "daemon/post/dialect.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

// Of the tool's direction from an axis of the machine.
constexpr double kAlong = 2e-3;

/// One stretch of compensation, from its first event to the one that ends it.
class Stretch {
 public:
  Stretch(const JointPath& joints, const config::MachineProfile& machine, const Setup& setup)
      : joints_(joints), machine_(machine), setup_(setup) {}

  /// What is wrong, or nothing and `plane`.
  std::optional<std::string> look(std::size_t first, std::size_t last, ShiftPlane& plane) const;

 private:
  bool serves(int code) const {
    const DialectTable& table = table_of(machine_.format.dialect);
    return code == 17 || (code == 18 && table.shifts_in_zx) || (code == 19 && table.shifts_in_yz);
  }

  const JointPath& joints_;
  const config::MachineProfile& machine_;
  const Setup& setup_;
};

std::optional<std::string> Stretch::look(std::size_t first, std::size_t last, ShiftPlane& plane) const {
  const auto& moves = joints_.moves;
  bool seen = false;
  for (std::size_t i = 0; i < moves.size() && moves[i].move < last; ++i) {
    if (moves[i].move < first) continue;
    const Joints& j = moves[i].joints;
    if (i > 0 && (j.a != moves[i - 1].joints.a || j.c != moves[i - 1].joints.c))
      return "a rotary turns while the control shifts the tool";
    if (seen || machine_.format.tilted_planes) continue;  // in its plane the tool is along Z
    seen = true;
    const auto at = shift_plane(machine_.model, setup_, j);
    if (!at)
      return "the tool is along no axis of the machine there, and the control works in the plane of two";
    if (!serves(at->code))
      return "the tool is not along Z there, and the control shifts it in no plane but that of X and Y" +
             std::string(at->code == 19 && serves(18) ? ", and of Z and X" : "");
    plane = *at;
  }
  return std::nullopt;
}

/// The event with the side that the control has in this plane.
PathEvent told(PathEvent event, const ShiftPlane& plane) {
  if (plane.backward)
    event.kind = event.kind == EventKind::kCutterLeft ? EventKind::kCutterRight : EventKind::kCutterLeft;
  return event;
}

}  // namespace

std::optional<ShiftPlane> shift_plane(const MachineModel& machine, const Setup& setup, const Joints& joints) {
  const Pose pose = forward(machine, setup, joints);
  const Joints up = solve_linear(machine, setup, pose.tip + pose.axis, joints.a, joints.c);
  const std::array<double, 3> along{up.x - joints.x, up.y - joints.y, up.z - joints.z};
  constexpr std::array<int, 3> kCodes{19, 18, 17};
  for (std::size_t i = 0; i < along.size(); ++i) {
    const double rest = std::hypot(along[(i + 1) % 3], along[(i + 2) % 3]);
    if (rest <= kAlong && std::abs(std::abs(along[i]) - 1.0) <= kAlong)
      return ShiftPlane{kCodes[i], along[i] < 0.0};
  }
  return std::nullopt;
}

Result<std::vector<PathEvent>> control_events(const AptOperation& op, const JointPath& joints,
                                              const config::MachineProfile& machine, const Setup& setup,
                                              int tool, const std::string& name) {
  constexpr double kThroughSpindle = 3.0;
  constexpr const char* kLeave = "; where the points are the cutter's centre, say --ignore CUTCOM";
  const DialectTable& table = table_of(machine.format.dialect);
  std::vector<PathEvent> out;
  ShiftPlane plane;
  for (auto event = op.events.begin(); event != op.events.end(); ++event) {
    const bool off = event->kind == EventKind::kCutterOff;
    if (event->kind == EventKind::kCoolant && event->value == kThroughSpindle &&
        machine.format.through_on.empty()) {
      const std::size_t move = std::min(event->move, op.lines.size() - 1);
      return fail(Code::kInput, name + ":" + std::to_string(op.lines[move]) +
                                    ": COOLNT/THRU before it: " + config::no_through_coolant(machine.path) +
                                    "; where flood does, say COOLNT/FLOOD");
    }
    if (off || (event->kind != EventKind::kCutterLeft && event->kind != EventKind::kCutterRight)) {
      out.push_back(*event);
      if (off && plane.code != 17) out.push_back({event->move, EventKind::kPlane, 17.0, ""});
      if (off) plane = {};
      continue;
    }
    const auto end = std::find_if(event, op.events.end(),
                                  [](const PathEvent& one) { return one.kind == EventKind::kCutterOff; });
    const auto wrong = [&](const std::string& what) {
      const std::size_t move = std::min(event->move, op.lines.size() - 1);
      return fail(Code::kInput, name + ":" + std::to_string(op.lines[move]) + ": CUTCOM/: " + what + kLeave);
    };
    if (*table.cutter_left == '\0')
      return wrong(std::string(config::name_of(machine.format.dialect).name) + " has no words for it");
    if (machine.format.tcp)
      return wrong("a control that keeps the tool centre point does not shift the tool");
    if (event->value == 0.0 && tool == 0)
      return wrong("its register is the tool's, and the tool has no number");
    const bool has_register = std::string_view(table.cutter_left).find("{cutter}") != std::string_view::npos;
    const int called = op.length_register > 0 ? op.length_register : tool;
    if (!has_register && event->value != 0.0 && event->value != called)
      return wrong("register " + decimal(event->value, 0) +
                   " is stated, and this control takes the radius of the tool that is called");
    if (table.sides != Sides::kLine && end == op.events.end())
      return wrong("no CUTCOM/OFF ends it, which this control needs, and a move beside the part behind it");
    const ShiftPlane before = plane;
    const std::size_t last = end == op.events.end() ? op.path.moves.size() : end->move;
    if (const auto bad = Stretch(joints, machine, setup).look(event->move, last, plane)) return wrong(*bad);
    if (plane.code != before.code) out.push_back({event->move, EventKind::kPlane, double(plane.code), ""});
    out.push_back(told(*event, plane));
  }
  return out;
}

}  // namespace tiltfeed::daemon
