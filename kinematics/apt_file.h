#pragma once
// CL text of any CAM system: APT records with GOTO, RAPID, FEDRAT, SPINDL, COOLNT, LOADTL and their kin. Our
// own files: cl_file.h.

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "kinematics/path_event.h"
#include "kinematics/result.h"
#include "kinematics/tool_path.h"

namespace tiltfeed {

/// What one tool does.
struct AptOperation {
  ToolPath path;                     ///< every feed move is a cut, its feed by ToolPath::feeds
  int tool_number = 0;               ///< 0: not stated
  std::vector<PathEvent> events;     ///< by rising move
  std::vector<std::uint32_t> lines;  ///< of the text, by move
};

struct AptProgram {
  std::string name;
  std::vector<AptOperation> operations;
  std::vector<std::string> notes;  ///< words that were not understood, with their first line
};

struct AptOptions {
  double unit_mm = 0.0;      ///< length of the file's unit until UNITS/ says otherwise; 0: not known, mm
  double tool_length = 0.0;  ///< of tools whose LOADTL/ states none, mm
};

/// Reads records with `$` continuation and `$$` comments, upper or lower case. GOTO/x,y,z[,i,j,k] with axes
/// of any length, GODLTA/, FROM/ (no move), TLAXIS/; RAPID for the next move; FEDRAT/ in MMPM, IPM, MMPR, IPR
/// or the file's unit; SPINDL/, COOLNT/, DELAY/, STOP, OPSTOP, PPRINT; CUTTER/, TLDATA/MILL, LOADTL/ (a new
/// operation), UNITS/. Properties: every operation has a move, its first is a rapid; axes are unit. Words
/// that only inform are skipped, unknown ones noted. Errors: kInput as name:line: a number that is missing or
/// none, no feed, one in inches in a file of unknown unit, an axis of no length, what would need another
/// motion than straight lines (CYCLE, CIRCLE, CUTCOM, ROTABL, TRACUT ...), no GOTO, no FINI, END or
/// END-OF-PATH.
Result<AptProgram> read_apt(std::istream& in, const std::string& name, const AptOptions& options);

/// Writes it, in mm: 6 decimals for mm, 9 for axis components. `read_apt` reads it back, lines and notes
/// excepted.
void write_apt(const AptProgram& program, std::ostream& out);

}  // namespace tiltfeed
