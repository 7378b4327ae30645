#pragma once
// LineReader text of any dialect that daemon/post/block.cpp writes, read back: the words of every motion
// block and what stands between them. A reader of its own; it shares no code with the writer.

#include <array>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "config/program_format.h"
#include "daemon/post/nc_planes.h"
#include "daemon/post/text_language.h"
#include "kinematics/basics/geometry.h"
#include "kinematics/basics/path_event.h"
#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

struct TextBlock {
  Joints words;  ///< as printed; under TCP X Y Z are the tip's
  bool rapid = true;
  bool tcp = false;
  bool inverse_time = false;
  double feed = 0.0;  ///< F in force, 0 for rapids
  std::uint32_t line = 0;
  std::uint32_t plane = 0;  ///< of NcProgram::planes, from 1: X Y Z are in it; 0: none
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
};

/// Reads to the program's end. Moves in machine coordinates (G53, G28, SUPA, M91) leave the place unknown
/// until it is stated again; blocks begin where all five words are known. Errors: kInput as name:line:
/// inches, arcs, cycles, incremental words, planes that turn the rotaries by themselves, words that are not
/// known or that would be misread (nc_rules.h), another work offset behind the first block, a feed move
/// without F or before all words are known, no block; kLimit: more than the limits there.
Result<NcProgram> read_nc_program(std::istream& in, const std::string& name, const TextLanguage& language);

}  // namespace tiltfeed::daemon
