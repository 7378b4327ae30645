#pragma once
// CL text of any CAM system: APT records with GOTO, RAPID, FEDRAT, SPINDL, COOLNT, LOADTL, CYCLE, CIRCLE,
// CUTCOM and their kin. Our own files: cl_file.h.

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "kinematics/basics/path_event.h"
#include "kinematics/basics/result.h"
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
};

/// Reads records with `$` continuation and `$$` comments, upper or lower case. GOTO/x,y,z[,i,j,k] with axes
/// of any length, GODLTA/, GOHOME/, FROM/ (no move), TLAXIS/; RAPID for the next move; FEDRAT/ in MMPM, IPM,
/// MMPR, IPR or the file's unit; SPINDL/, COOLNT/, DELAY/, STOP, OPSTOP, PPRINT; CUTTER/, TLDATA/, LOADTL/ (a
/// new operation); CYCLE/ and CIRCLE/ as straight moves; CUTCOM/ as events; MSYS/ applied, CSYS/ where
/// TRNTYP/ says that the points are the part's; UNIT/ and UNITS/, which hold for all of the file and stand
/// before its first motion. Properties: every operation has a move, its first is a rapid; axes are unit.
/// Words that only inform are skipped, unknown ones noted. Errors: kInput as name:line:column: a number that
/// is missing or none or looks like a decimal comma, no feed, one in inches in a file of unknown unit, an
/// axis of no length, words that move or turn what follows and are not understood (ROTABL, TRACUT, COPY,
/// MODE/INCR ...), unknown ones with numbers like a motion, no GOTO, no FINI, END or END-OF-PATH.
Result<AptProgram> read_apt(std::istream& in, const std::string& name, const AptOptions& options);

/// Writes it, in mm: 6 decimals for mm, 9 for axis components. `read_apt` reads it back, lines and notes
/// excepted.
void write_apt(const AptProgram& program, std::ostream& out);

}  // namespace tiltfeed
