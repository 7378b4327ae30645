#pragma once
// A program's text as data: the words of every motion block, and what stands between them.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/post/nc_planes.h"
#include "kinematics/basics/geometry.h"
#include "kinematics/basics/path_event.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// An arc as a block says it.
struct TextArc {
  int plane = 17;                    ///< 17: X Y, 18: Z X, 19: Y Z
  bool clockwise = false;            ///< as seen from the positive end of the third axis
  double first = 0.0, second = 0.0;  ///< the centre's place along the plane's axes, mm
};

struct TextBlock {
  Joints words;  ///< as printed; under TCP X Y Z are the tip's
  bool rapid = true;
  bool tcp = false;
  bool inverse_time = false;
  double feed = 0.0;  ///< F in force, 0 for rapids
  std::uint32_t line = 0;
  std::uint32_t plane = 0;  ///< of NcProgram::planes, from 1: X Y Z are in it; 0: none
  std::uint32_t arc = 0;    ///< of NcProgram::arcs, from 1; 0: it is straight
};

/// The blocks of one tool.
struct TextOperation {
  int tool_number = 0;
  int length_register = 0;  ///< where it is not that of the tool's number
  std::vector<TextBlock> blocks;
  std::vector<PathEvent> events;  ///< `move` counts blocks
  // From the header comments, where they say so.
  std::optional<double> tool_length, diameter;
  std::optional<Vec3> part_zero, fixture_deg;
};

struct NcProgram {
  std::string name;
  std::vector<TextOperation> operations;  ///< each with a block
  std::vector<std::string> notes;         ///< words left out, with their line
  std::vector<TextPlane> planes;
  std::vector<TextArc> arcs;
  bool own_offsets = false;  ///< its header says that each plane has a work offset of its own, at part zero
};

}  // namespace tiltfeed::daemon
