#include "daemon/post/tilted_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/post/printed_path.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/machine/machine.h"
#include "kinematics/machine/spindle_frame.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed::daemon {
namespace {

using config::Dialect;

PlaneAngles rounded(PlaneAngles angles, int decimals) {
  for (double& angle : angles) angle = round_decimal(angle, decimals);
  return angles;
}

/// "I40. J35. K-20."
std::string zxz_text(const PlaneAngles& angles, int decimals) {
  constexpr std::string_view kLetters = "IJK";
  std::string text;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const std::string number = decimal(angles[i], decimals);
    if (i > 0) text += ' ';
    text += kLetters[i];
    text += number;
    if (number.find('.') == number.npos) text += '.';
  }
  return text;
}

/// "SPA+33.3 SPB+11.3 SPC+23.4": the last turn first.
std::string spatial_text(const PlaneAngles& angles, int decimals) {
  constexpr std::array<const char*, 3> kNames{"SPA", " SPB", " SPC"};
  std::string text;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double angle = angles[angles.size() - 1 - i];
    text += kNames[i];
    if (angle >= 0.0) text += '+';
    text += decimal(angle, decimals);
  }
  return text;
}

/// "23.4,11.3,33.3".
std::string listed_text(const PlaneAngles& angles, int decimals) {
  std::string text = decimal(angles[0], decimals);
  for (std::size_t i = 1; i < angles.size(); ++i) text.append(",").append(decimal(angles[i], decimals));
  return text;
}

}  // namespace

TiltedPlane tilted_plane(const config::MachineProfile& machine, double a, double c) {
  const MachineModel& model = machine.model;
  const Dialect dialect = machine.format.dialect;
  const int decimals = machine.format.rotary_decimals;
  const Rotation frame = spindle_frame(model, a, c);
  if (config::plane_follows_table(dialect)) return {frame, {}};
  if (dialect == Dialect::kFanuc) {
    const PlaneAngles angles = rounded(zxz_angles(frame), decimals);
    return {from_zxz(angles), {{"angles", zxz_text(angles, decimals)}}};
  }
  // Of two places of the rotaries that give the plane: on which side of home the tilt is.
  const bool below = a < model.tilt.zero;
  const PlaneAngles angles = rounded(zyx_angles(frame), decimals);
  const bool siemens = dialect == Dialect::kSiemens;
  return {from_zyx(angles),
          {{"angles", siemens ? listed_text(angles, decimals) : spatial_text(angles, decimals)},
           {"side", siemens ? (below ? "-1" : "1") : (below ? "SEQ-" : "SEQ+")}}};
}

std::optional<std::vector<AxisRun>> axis_runs(const ToolPath& path, const std::vector<std::size_t>& begins) {
  std::vector<AxisRun> runs;
  bool feeds = false;
  std::size_t first = 0;
  for (std::size_t i = 1; i <= path.moves.size(); ++i) {
    const bool ends = i == path.moves.size() || path.moves[i].pose.axis != path.moves[first].pose.axis ||
                      std::binary_search(begins.begin(), begins.end(), i);
    if (!ends) {
      feeds = feeds || path.moves[i].kind != MoveKind::kRapid;
      continue;
    }
    if (i < path.moves.size() && path.moves[i].kind != MoveKind::kRapid) return std::nullopt;
    if (feeds) runs.push_back({first, i});
    first = i, feeds = false;
  }
  if (runs.empty()) return std::nullopt;
  return runs;
}

ToolPath part_of(const ToolPath& path, const AxisRun& run) {
  ToolPath part{path.name, path.tool, path.cut_feed, path.plunge_feed, {}, {}};
  part.moves.assign(path.moves.begin() + static_cast<std::ptrdiff_t>(run.first),
                    path.moves.begin() + static_cast<std::ptrdiff_t>(run.last));
  part.moves.front().kind = MoveKind::kRapid;
  for (const FeedChange& change : path.feeds) {
    if (change.move >= run.last) break;
    const auto at = static_cast<std::uint32_t>(change.move > run.first ? change.move - run.first : 0);
    if (!part.feeds.empty() && part.feeds.back().move == at) part.feeds.pop_back();
    part.feeds.push_back({at, change.feed});
  }
  return part;
}

AptOperation part_of(const AptOperation& operation, const AxisRun& run) {
  AptOperation part{part_of(operation.path, run), operation.tool_number, operation.length_register, {}, {}};
  const auto at = [&](std::size_t move) {
    return operation.lines.begin() + static_cast<std::ptrdiff_t>(move);
  };
  part.lines.assign(at(run.first), at(run.last));
  return part;
}

void RunJoints::add(const JointPath& joints, std::size_t first_move, SwingWay way) {
  const auto offset = static_cast<std::uint32_t>(first_move);
  if (path.moves.empty())
    path.report = joints.report;
  else
    path.report.add(joints.report);
  if (!path.moves.empty())
    for (JointMove& move :
         moves_between(machine_, path.moves.back().joints, joints.moves.front().joints, way)) {
      move.move = offset;
      path.moves.push_back(move);
    }
  const std::size_t first = path.moves.size();
  for (const JointMove& move : joints.moves) {
    path.moves.push_back(move);
    path.moves.back().move += offset;
  }
  if (first > 0)
    path.moves[first].seconds =
        rapid_seconds(machine_, path.moves[first - 1].joints, path.moves[first].joints);
  runs.push_back({first, path.moves.size(), way});
}

JointPath words_in_plane(const JointPath& joints, const AxisRun& run, const config::MachineProfile& machine,
                         const Setup& setup, const TiltedPlane& plane) {
  const Rotation back = transposed(plane.frame);
  JointPath words;
  words.moves.assign(joints.moves.begin() + static_cast<std::ptrdiff_t>(run.first),
                     joints.moves.begin() + static_cast<std::ptrdiff_t>(run.last));
  words.moves.front().seconds = 0.0;
  for (JointMove& move : words.moves) {
    const Vec3 tip = back * (setup.fixture * from_origin(forward(machine.model, setup, move.joints).tip));
    move.joints = {tip.x, tip.y, tip.z, move.joints.a, move.joints.c};
    words.report.seconds += move.seconds;
  }
  return printed_path(std::move(words), machine.format);
}

Joints from_plane(const TiltedPlane& plane, const Joints& words) {
  const Vec3 tip = plane.frame * Vec3{words.x, words.y, words.z};
  return {tip.x, tip.y, tip.z, words.a, words.c};
}

}  // namespace tiltfeed::daemon
