#pragma once
// Work with standing rotaries in the control's own tilted plane: X Y Z are the tip's in the spindle's frame
// about part zero (K14), and the control knows the machine.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/machine_profile.h"
#include "daemon/post/swing.h"
#include "kinematics/cl_text/apt_operation.h"
#include "kinematics/joints/joint_moves.h"

namespace tiltfeed::daemon {

/// A plane as the control is told it. Property: `frame` is that of the printed angles, so that the words
/// carry no error of theirs.
struct TiltedPlane {
  Rotation frame;  ///< directions of the plane to those of the work with the table at home
  std::vector<std::pair<std::string_view, std::string>> words;  ///< {angles}, {side} of a Filling (dialect.h)
};

/// The plane for these rotary words. Requires: config::has_tilted_planes().
TiltedPlane tilted_plane(const config::MachineProfile& machine, double a, double c);

/// Moves of a tool path from `first` to before `last` that have one axis.
struct AxisRun {
  std::size_t first = 0, last = 0;
  SwingWay way{};  ///< to it from the run before
};

/// The runs that have a move at feed, in order; rapids that turn the tool between them are left out.
/// `begins`: rapids with which a run begins though the axis stays, rising. Nothing where the tool turns while
/// it cuts.
std::optional<std::vector<AxisRun>> axis_runs(const ToolPath& path,
                                              const std::vector<std::size_t>& begins = {});

/// The run alone, with the feeds in force there.
ToolPath part_of(const ToolPath& path, const AxisRun& run);
AptOperation part_of(const AptOperation& operation, const AxisRun& run);

/// The runs' joints one after the other, with moves_between() them.
class RunJoints {
 public:
  explicit RunJoints(const MachineModel& machine) : machine_(machine) {}
  /// `first_move`: what the moves of `joints` count from in the whole path; `way`: from the run before.
  void add(const JointPath& joints, std::size_t first_move, SwingWay way);

  JointPath path;             ///< of all
  std::vector<AxisRun> runs;  ///< in `path`, without what is between

 private:
  const MachineModel& machine_;
};

/// The words of a run of `joints`, all with one place of the rotaries, in its plane; blocks that change no
/// word are left out. Property: the tip is where the joints put it, within half of the last decimal an axis.
JointPath words_in_plane(const JointPath& joints, const AxisRun& run, const config::MachineProfile& machine,
                         const Setup& setup, const TiltedPlane& plane);

/// Words in the plane as words under TCP: of the tip in the part's frame with the table at home.
Joints from_plane(const TiltedPlane& plane, const Joints& words);

}  // namespace tiltfeed::daemon
