#pragma once
// The tool path as APT CL text: PARTNO, UNITS/MM, MULTAX, CUTTER/d,r, LOADTL/n,LENGTH,l, SPINDL/, COOLNT/,
// FEDRAT/f,MMPM, RAPID, GOTO/x,y,z,i,j,k, FINI; PPRINT remarks state both feeds. GOTO states the tool *tip*
// and the unit axis from tip to shank, part coordinates, mm.

#include <iosfwd>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/basics/tool_path.h"

namespace tiltfeed {

/// Writes `path` as CL text: 6 decimals for mm, 9 for axis components; RAPID precedes each rapid GOTO,
/// FEDRAT/ appears where the feed changes; cut and plunge are told apart by it, or by a remark where both
/// feeds are the same.
void write_cl(const ToolPath& path, std::ostream& out);
/// One operation of a CL file.
struct ClOperation {
  const ToolPath* path;
  int tool = 1;              ///< LOADTL/
  int length_register = 0;   ///< ADJUST; 0: that of the tool's number
  double spindle_rpm = 0.0;  ///< below 0: counter-clockwise; 0: no word
  double coolant = 0.0;      ///< as PathEvent::value of kCoolant
};
/// Several, one after the other, as one file: what a control's program is posted from. Requires: at least
/// one.
void write_cl(const std::vector<ClOperation>& operations, std::ostream& out);

/// Reads CL text that `write_cl` wrote back to the same path, to the decimals written (facets excepted: CL
/// text has none). It reads with `read_apt`, so a file of another CAM system is read, too: its first feed is
/// the cutting feed and another one the plunge feed. Errors: those of `read_apt`; kInput with `name`:line
/// for a third feed, a second tool, and a word that is not understood.
Result<ToolPath> read_cl(std::istream& in, const std::string& name);

}  // namespace tiltfeed
