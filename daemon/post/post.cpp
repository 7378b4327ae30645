#include "daemon/post/post.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "daemon/post/dialect.h"
#include "kinematics/cl_text/safe_approach.h"
#include "kinematics/timing/tcp_path.h"

namespace tiltfeed::daemon {
namespace {

/// The error with the CL line of the move that it names ("move 12, ...") in front.
Error at_line(const Error& error, const std::string& name, const AptOperation& op) {
  constexpr std::string_view kMove = "move ";
  if (!error.message.starts_with(kMove)) return {error.code, name + ": " + error.message};
  const auto move =
      static_cast<std::size_t>(std::strtoull(error.message.c_str() + kMove.size(), nullptr, 10));
  if (move >= op.lines.size()) return {error.code, name + ": " + error.message};
  return {error.code, name + ":" + std::to_string(op.lines[move]) + ": " + error.message};
}

// Of the tool's direction from the machine's z, where the control shifts it in the plane of X and Y.
constexpr double kAlongZ = 2e-3;

/// Where the control is to shift the tool to a side of its way, it works in the plane of X and Y: the
/// rotaries stand and the tool is along Z.
Result<void> check_compensation(const AptOperation& op, const JointPath& path,
                                const config::MachineProfile& machine, const Setup& setup, int tool,
                                const std::string& name) {
  constexpr const char* kLeave = "; where the points are the cutter's centre, say --ignore CUTCOM";
  const DialectTable& table = table_of(machine.format.dialect);
  std::size_t at = 0;
  for (auto event = op.events.begin(); event != op.events.end(); ++event) {
    if (event->kind != EventKind::kCutterLeft && event->kind != EventKind::kCutterRight) continue;
    const auto end = std::find_if(event, op.events.end(),
                                  [](const PathEvent& one) { return one.kind == EventKind::kCutterOff; });
    const std::size_t last = end == op.events.end() ? op.path.moves.size() : end->move;
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
    for (; at < path.moves.size() && path.moves[at].move < event->move; ++at) {
    }
    for (std::size_t i = at; i < path.moves.size() && path.moves[i].move < last; ++i) {
      const Joints& j = path.moves[i].joints;
      if (i > 0 && (j.a != path.moves[i - 1].joints.a || j.c != path.moves[i - 1].joints.c))
        return wrong("a rotary turns while the control shifts the tool");
      const Pose pose = forward(machine.model, setup, j);
      const Joints up = solve_linear(machine.model, setup, pose.tip + pose.axis, j.a, j.c);
      if (std::hypot(up.x - j.x, up.y - j.y, up.z - j.z - 1.0) > kAlongZ)
        return wrong("the tool is not along Z there, and the control works in the plane of X and Y");
    }
  }
  return {};
}

}  // namespace

Result<Posted> post(const AptProgram& program, const std::string& name,
                    const config::MachineProfile& stated_machine, const PostOptions& options) {
  config::MachineProfile machine = stated_machine;
  machine.format = config::fine_enough(machine.format, options.tolerance, options.axis_tolerance);
  Posted out;
  out.posting = {program.name, machine, options.data, {}};
  const config::ProgramFormat& format = machine.format;
  JointPathOptions joints;
  joints.tolerance = options.tolerance - program.chord_error;
  if (!(joints.tolerance > 0.0))
    return fail(Code::kInput, name + ": the chords of its arcs take all of the tolerance");
  joints.axis_tolerance = format.tcp ? options.axis_tolerance / 2.0 : options.axis_tolerance;
  joints.linear_decimals = format.tcp ? kTcpDecimals : format.linear_decimals;
  joints.rotary_decimals = format.rotary_decimals;
  joints.clear = options.clear;
  std::vector<JointMove> all;
  for (const AptOperation& stated : program.operations) {
    Setup setup = options.setup;
    setup.tool_length = stated.path.tool.length;
    if (!(setup.tool_length > 0.0))
      return fail(Code::kInput, name + ": tool " + std::to_string(stated.tool_number) +
                                    " has no length; state LOADTL/n,LENGTH,l in the file or --tool-length");
    AptOperation op = options.clear.height
                          ? with_safe_approach(stated, machine.model, setup, *options.clear.height)
                          : stated;
    auto path = to_joints(op.path, machine.model, setup, joints);
    if (!path && path.error().code == Code::kLimit && options.clear.height)
      if (const auto why = out_of_travel_at_ends(stated, machine.model, setup, *options.clear.height))
        return fail(Code::kLimit, name + ":" + *why);
    if (!path) return tl::unexpected(at_line(path.error(), name, op));
    op = reconfigured(std::move(op), *path);
    const int tool = op.tool_number > 0 ? op.tool_number : options.data.tool;
    if (auto valid = check_compensation(op, *path, machine, setup, tool, name); !valid)
      return tl::unexpected(valid.error());
    all.insert(all.end(), path->moves.begin(), path->moves.end());
    if (out.words.empty())
      out.report = path->report;
    else
      out.report.add(path->report);
    if (format.tcp)
      *path = words_under_tcp(*path, machine.model, setup,
                              {format.linear_decimals, options.axis_tolerance / 2.0});
    out.words.push_back(std::make_unique<JointPath>(std::move(*path)));
    out.posting.operations.push_back({out.words.back().get(), setup, op.path.tool, tool, op.path.cut_feed,
                                      op.path.plunge_feed, op.path.feeds, op.events, op.length_register});
  }
  out.timing = time_blocks(all, machine.model, options.tolerance, options.axis_tolerance, corners_of(format));
  out.posting.seconds = out.timing.seconds;
  return out;
}

}  // namespace tiltfeed::daemon
