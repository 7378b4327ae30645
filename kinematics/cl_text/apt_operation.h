#pragma once
// CL text as data: what each tool does, and what a reader is told.

#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/basics/path_event.h"
#include "kinematics/basics/tool_path.h"

namespace tiltfeed {

/// What one tool does.
struct AptOperation {
  ToolPath path;                     ///< every feed move is a cut, its feed by ToolPath::feeds
  int tool_number = 0;               ///< 0: not stated
  int length_register = 0;           ///< that holds the tool's length; 0: the tool's number
  std::vector<PathEvent> events;     ///< by rising move
  std::vector<std::uint32_t> lines;  ///< of the text, by move
};

struct AptProgram {
  std::string name;
  std::vector<AptOperation> operations;
  std::vector<std::string> notes;  ///< words that were not understood, with their first line
  double chord_error = 0.0;        ///< of arcs as chords, mm; 0: it has none
};

struct AptOptions {
  double unit_mm = 0.0;         ///< length of the file's unit until UNITS/ says otherwise; 0: not known, mm
  double tool_length = 0.0;     ///< of tools whose LOADTL/ states none, mm
  double feed = 0.0;            ///< of feed moves before any FEDRAT/, mm/min; 0: such a move is an error
  double chord_error = 0.0025;  ///< most that a chord may be off its arc, mm
  std::vector<std::string> ignored = {};  ///< words that are left out; no motion word is
  bool own_remarks = false;               ///< PPRINT TILTFEED ... become events, too
};

}  // namespace tiltfeed
