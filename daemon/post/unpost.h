#pragma once
// The tool path that a program really makes: its blocks as the control interpolates them, on this machine.

#include <optional>
#include <vector>

#include "config/machine_profile.h"
#include "daemon/post/nc_reader.h"
#include "kinematics/basics/result.h"
#include "kinematics/cl_text/apt_file.h"

namespace tiltfeed::daemon {

struct UnpostOptions {
  double tolerance = 0.001;       ///< of the straight lines between points from the tip's true way, mm
  double axis_tolerance = 0.005;  ///< likewise of the axis, degrees
  // Instead of what the program's header states.
  std::optional<double> tool_length;
  std::optional<Vec3> part_zero, fixture_deg;
};

/// The pose that `words`, said as those of `block`, command: under TCP, in its plane, or of the slides.
Pose commanded_pose(const MachineModel& machine, const Setup& setup, const std::vector<TextPlane>& planes,
                    const TextBlock& block, const Joints& words);

/// Rz Ry Rx of angles in degrees about the table's x, y, z, as in a job file; multiples of 90 are exact.
Rotation fixture_of(Vec3 degrees);

/// Without TCP all axes travel linearly in a block, under TCP the tip in the part's frame and the rotaries
/// besides; points are put between so that straight lines and great circles stay within tolerance of that.
/// Feeds are those of the tip. The blocks in which the table turns to its place where TCP begins (tcp_start)
/// are no path, and are left out. Errors: kInput where neither the program nor the options state tool length
/// or part zero, or a word is beyond its axis's travel; kLimit: more points than kMostTextPoints.
Result<AptProgram> unpost(const NcProgram& program, const config::MachineProfile& machine,
                          const UnpostOptions& options);

}  // namespace tiltfeed::daemon
