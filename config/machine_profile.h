#pragma once
// The machine profile file: what the shop knows of one machine. Every key: config/machines/generic-ac.yaml.

#include <optional>
#include <string>
#include <vector>

#include "config/link_profile.h"
#include "config/machine_bodies.h"
#include "config/machine_vectors.h"
#include "config/magazine.h"
#include "config/program_format.h"
#include "config/section.h"
#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::config {

/// How the control plans speeds; the simulated machine does it so.
struct ControlModel {
  int look_ahead = 200;        ///< blocks; a link's buffer may hold fewer
  double corner_time = 0.005;  ///< s; an axis may change its speed at a corner by its acceleration times this
};

struct MachineProfile {
  std::string path;  ///< the file it came from
  MachineModel model;
  MachineBodies solid;  ///< what it looks like; without bodies it is not checked for collisions
  std::vector<MachineVector> vectors;  ///< measured places, which the model reproduces
  ControlModel control;
  ProgramFormat format;
  std::string link;          ///< default link of `tiltfeed send`, may be empty
  int receive_buffer = 127;  ///< of a character-counting controller, bytes
  double link_rate = 0.0;    ///< bytes/s that reach the control; 0: not known, then nothing is said of it
  LinkProfile wire;          ///< how its wire wants to be used
  Magazine magazine;         ///< empty: not known
};

/// Properties: every limit pair has min < max, speeds and accelerations are above 0, a jerk of 0 is no limit,
/// directions are unit, the tilt's is parallel neither to the rotary's nor to the spindle's, letters differ
/// and mean nothing else in G-code, the model reproduces every measured place. `dialect`: if it is not the
/// profile's, the section program is that dialect's defaults, but for clamps and line numbers. Errors: kInput
/// as file:line:column, what was expected, the nearest known key; kIo.
Result<MachineProfile> load_machine(const std::string& path, std::optional<Dialect> dialect = {});
/// The same from text; `path` names it in messages and becomes MachineProfile::path.
Result<MachineProfile> parse_machine(const std::string& text, const std::string& path,
                                     std::optional<Dialect> dialect = {});
/// The profile that the key `machine` of another settings file (`root`, a path relative to it) names; one
/// that cannot be read is a complaint about that key.
Result<MachineProfile> load_named_machine(const std::string& path, const Section& root,
                                          const Complaint& complaint);
/// The resolved profile, one `key: value` a line.
std::string describe(const MachineProfile& profile);

}  // namespace tiltfeed::config
