#include "daemon/post/post.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "daemon/post/arc_fit.h"
#include "daemon/post/cutter_side.h"
#include "daemon/post/printed_path.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/cl_text/safe_approach.h"
#include "kinematics/timing/control_timing.h"
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

/// A register is stated that this control cannot be told.
bool lacks_register(const config::ProgramFormat& format, const AptOperation& op) {
  const bool tnc =
      format.dialect == config::Dialect::kHeidenhain || format.dialect == config::Dialect::kHeidenhainIso;
  return tnc && op.length_register > 0 && op.length_register != op.tool_number;
}

/// A program by its tilted planes: an operation for each run of one axis.
struct PlaneProgram {
  std::vector<AptOperation> operations;
  std::vector<bool> goes_on;  ///< by operation: with the tool of the one before
};

/// Nothing where a cut turns the tool. An event that stands between two runs is the next one's.
std::optional<PlaneProgram> by_planes(const AptProgram& program) {
  PlaneProgram planes;
  for (const AptOperation& op : program.operations) {
    const std::optional<std::vector<AxisRun>> runs = axis_runs(op.path);
    if (!runs) return std::nullopt;
    auto event = op.events.begin();
    for (std::size_t i = 0; i < runs->size(); ++i) {
      const AxisRun& run = (*runs)[i];
      AptOperation part = part_of(op, run);
      const bool last = i + 1 == runs->size();
      for (; event != op.events.end() && (last || event->move < (*runs)[i + 1].first); ++event) {
        PathEvent moved = *event;
        moved.move = std::min(std::max(event->move, run.first) - run.first, part.path.moves.size());
        part.events.push_back(std::move(moved));
      }
      planes.operations.push_back(std::move(part));
      planes.goes_on.push_back(i > 0);
    }
  }
  return planes;
}

}  // namespace

Result<Posted> post(const AptProgram& program, const std::string& name,
                    const config::MachineProfile& stated_machine, const PostOptions& options) {
  config::MachineProfile machine = stated_machine;
  machine.format = config::fine_enough(machine.format, options.tolerance, options.axis_tolerance);
  const std::optional<PlaneProgram> runs = machine.format.tilted_planes ? by_planes(program) : std::nullopt;
  const bool planes = runs.has_value();
  const std::vector<AptOperation>& operations = planes ? runs->operations : program.operations;
  if (planes) machine.format = config::in_tilted_planes(machine.format);
  machine.format.tilted_planes = planes;
  if (auto begins = tcp_can_begin(machine, program.operations.size()); !begins)
    return tl::unexpected(begins.error());
  Posted out;
  out.posting = {program.name, machine, options.data, {}};
  const config::ProgramFormat& format = machine.format;
  JointPathOptions joints;
  joints.tolerance = options.tolerance - program.chord_error - format.blend_tolerance -
                     options.data.smoothing_tolerance - options.data.arc_tolerance;
  if (!(joints.tolerance > 0.0))
    return fail(Code::kInput,
                name +
                    ": the chords of its arcs, the profile's blend_tolerance_mm, --smoothing-tolerance and "
                    "--arc-tolerance take all of the tolerance; state a larger one (--tolerance)");
  joints.axis_tolerance = format.tcp ? options.axis_tolerance / 2.0 : options.axis_tolerance;
  joints.linear_decimals = joint_decimals(format);
  joints.rotary_decimals = format.rotary_decimals;
  if (!planes) joints.clear = options.clear;  // in a plane no rotary turns
  std::vector<JointMove> all;
  std::vector<std::pair<std::size_t, std::size_t>> starts;  // in `all`: the first block, how many
  for (std::size_t i = 0; i < operations.size(); ++i) {
    const AptOperation& stated = operations[i];
    const bool goes_on = planes && runs->goes_on[i];
    Setup setup = options.setup;
    setup.tool_length = stated.path.tool.length;
    if (!(setup.tool_length > 0.0))
      return fail(Code::kInput, name + ": tool " + std::to_string(stated.tool_number) +
                                    " has no length; state LOADTL/n,LENGTH,l in the file or --tool-length");
    if (lacks_register(format, stated))
      return fail(Code::kInput, name + ": LOADTL/" + std::to_string(stated.tool_number) + ",ADJUST," +
                                    std::to_string(stated.length_register) + ": " +
                                    config::name_of(format.dialect).name +
                                    " takes the length of the tool that is called and cannot be told a "
                                    "register; where it is the tool's own, say --ignore ADJUST");
    if (planes && !options.clear.height && stated.path.moves.back().kind != MoveKind::kRapid)
      return fail(Code::kInput,
                  name + ":" + std::to_string(stated.lines.back()) +
                      ": the tool is to be retracted along the machine's Z here, between two planes or at "
                      "the end, and has not left its cut; end it with a rapid off the part, or state "
                      "--clear-height");
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
    auto events = control_events(op, *path, machine, setup, tool, name);
    if (!events) return tl::unexpected(events.error());
    const std::vector<JointMove> start = start_moves(machine, setup, path->moves);
    const std::size_t before = start.empty() ? 0 : start.size() - 1;
    if (goes_on) {
      const std::vector<JointMove> turn =
          moves_between(machine.model, all.back().joints, path->moves.front().joints);
      starts.emplace_back(all.size(), turn.size());
      all.insert(all.end(), turn.begin(), turn.end());
    }
    starts.emplace_back(all.size(), before);
    all.insert(all.end(), start.begin(), start.begin() + static_cast<std::ptrdiff_t>(before));
    all.insert(all.end(), path->moves.begin(), path->moves.end());
    if (before > 0) all[all.size() - path->moves.size()] = start.back();
    if (out.words.empty())
      out.report = path->report;
    else
      out.report.add(path->report);
    if (format.tcp)
      *path = words_under_tcp(
          *path, machine.model, setup,
          {format.inches ? kTcpDecimals : format.linear_decimals, options.axis_tolerance / 2.0});
    if (format.inches && !planes) *path = printed_path(std::move(*path), format);
    std::optional<TiltedPlane> plane;
    if (planes) {
      const Joints& at = path->moves.front().joints;
      plane = tilted_plane(machine, at.a, at.c);
      *path = words_in_plane(*path, {0, path->moves.size()}, machine, setup, *plane);
    }
    out.words.push_back(std::make_unique<JointPath>(std::move(*path)));
    out.posting.operations.push_back({out.words.back().get(),
                                      setup,
                                      op.path.tool,
                                      tool,
                                      op.path.cut_feed,
                                      op.path.plunge_feed,
                                      op.path.feeds,
                                      std::move(*events),
                                      op.length_register,
                                      std::move(plane),
                                      {},
                                      goes_on});
    out.posting.operations.back().smoothing = options.data.smoothing;
    out.posting.operations.back().smoothing_tolerance = options.data.smoothing_tolerance;
    put_arcs(out.posting.operations.back(), format, options.data.arc_tolerance, out.words);
  }
  out.timing = time_moves(all, machine, options.tolerance, options.axis_tolerance);
  out.posting.seconds = out.timing.seconds;
  // Of the blocks of the operations alone.
  for (auto start = starts.rbegin(); start != starts.rend(); ++start) {
    const auto at = out.timing.durations.begin() + static_cast<std::ptrdiff_t>(start->first);
    out.timing.durations.erase(at, at + static_cast<std::ptrdiff_t>(start->second));
  }
  return out;
}

Timing time_moves(const std::vector<JointMove>& moves, const config::MachineProfile& machine,
                  double tolerance, double axis_tolerance) {
  const config::ProgramFormat& format = machine.format;
  const Corners corners = corners_of(format);
  // LinuxCNC's rules are measured on it.
  if (corners != Corners::kBlended || !machine.model.blends_rotary)
    return time_blocks(moves, machine.model, rounded_off_by(format, tolerance), axis_tolerance, corners);
  const bool inverse = !format.tcp && format.feed_mode == config::FeedMode::kInverseTime;
  return time_on_control(moves, machine.model,
                         {machine.control.corner_time, static_cast<std::size_t>(machine.control.look_ahead),
                          inverse ? 60.0 / format.max_inverse_time : 0.0});
}

}  // namespace tiltfeed::daemon
