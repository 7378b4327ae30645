#pragma once
// Places that were measured on a machine: what its profile must reproduce. A wrong sign mirrors the part and
// is seen by nothing else.

#include <optional>
#include <string>
#include <vector>

#include "config/description.h"
#include "config/section.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::config {

/// Axis words, and where the tool was then found.
struct MachineVector {
  Joints words;
  Setup setup;               ///< fixture: none
  Point<Part> tip;           ///< in the coordinates of the part that turns with the table, mm
  std::optional<Vec3> axis;  ///< unit, from tip to shank, where it was seen too
  double tolerance = 0.05;   ///< of the tip, mm: what was measured with
};

/// The key check: a list of maps x_mm y_mm z_mm tilt_deg rotary_deg tip_mm axis part_zero_mm tool_length_mm
/// tolerance_mm. Complains at the first vector that `model` does not reproduce, with what would.
std::vector<MachineVector> read_vectors(const Section& root, const MachineModel& model);
void describe_vectors(Description& out, const std::vector<MachineVector>& vectors);

/// Why the model does not reproduce a vector; nothing where it does. Names the profile keys whose other sign
/// would make it right.
std::optional<std::string> disagreement(const MachineModel& model, const MachineVector& vector);

}  // namespace tiltfeed::config
