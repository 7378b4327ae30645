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
#include "kinematics/cl_text/apt_operation.h"

namespace tiltfeed {

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

/// Its line, as SPINDL/8000,RPM,CLW; kPlane has none.
void append_event(std::string& text, const PathEvent& event);

/// "RAPID" where it is one, and "GOTO/x,y,z,i,j,k", to those decimals.
void append_move(std::string& text, const Move& move);

}  // namespace tiltfeed
