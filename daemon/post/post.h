#pragma once
// CL text of any CAM system to a posting: every operation's joints on this machine, ready to be written.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "daemon/post/block.h"
#include "kinematics/basics/result.h"
#include "kinematics/cl_text/apt_file.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed::daemon {

struct PostOptions {
  double tolerance = 0.005;      ///< of the tip as the machine moves it, mm
  double axis_tolerance = 0.05;  ///< of the axis, degrees
  Setup setup;                   ///< part zero and fixture; the length is the tool's
  /// With a height the tool comes to and leaves every operation along its axis from there; with either it may
  /// be taken off in between to turn a rotary back.
  ClearSpace clear;
  config::ProgramData data;
};

/// A posting and the words that it points to.
struct Posted {
  std::vector<std::unique_ptr<JointPath>> words;
  Posting posting;
  JointPathReport report;  ///< of all operations
  Timing timing;  ///< of all of them, one after the other; seconds and peaks with those in which TCP begins
};

/// Errors: as to_joints, with `name`:line of the CL text; kInput for a tool without length.
Result<Posted> post(const AptProgram& program, const std::string& name, const config::MachineProfile& machine,
                    const PostOptions& options);

/// How the control passes corners in a program of this format.
inline Corners corners_of(const config::ProgramFormat& format) {
  if (format.path_control == config::PathControl::kBlend) return Corners::kFixed;
  return format.path_control == config::PathControl::kExact ? Corners::kExact : Corners::kBlended;
}
/// By how much the control rounds corners off, mm, where the post's own tolerance is this.
inline double rounded_off_by(const config::ProgramFormat& format, double tolerance) {
  return format.path_control == config::PathControl::kBlend ? kBlendWord * format.blend_tolerance : tolerance;
}

/// Times of joint moves on the control of this profile, whose post has these tolerances (mm, degrees).
Timing time_moves(const std::vector<JointMove>& moves, const config::MachineProfile& machine,
                  double tolerance, double axis_tolerance);

}  // namespace tiltfeed::daemon
