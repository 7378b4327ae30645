#pragma once
// The canonical commands that LinuxCNC's interpreter (rs274) makes of a program, as blocks: a second reading
// of the same text, by another program. The commands that are taken are listed in sim/gcode/README.md.

#include <istream>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"
#include "sim/gcode/gcode_reader.h"

namespace tiltfeed::sim {

/// What `rs274 -g` prints, up to PROGRAM_END. Feed moves get F in mm/min, as printed; Block::line is the
/// number before the command. Errors: kInput with `name`:line: a command that is none, that this machine has
/// not (arcs, probing, offsets, inches), a feed move before any rate, a machine whose rotary letters are not
/// of A B C, no PROGRAM_END.
Result<std::vector<Block>> read_canon(std::istream& in, const std::string& name, const MachineModel& machine);

}  // namespace tiltfeed::sim
