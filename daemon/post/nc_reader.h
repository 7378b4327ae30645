#pragma once
// LineReader text of any dialect that daemon/post/block.cpp writes, read back: the words of every motion
// block and what stands between them. A reader of its own; it shares no code with the writer.

#include <iosfwd>
#include <string>

#include "daemon/post/nc_program.h"
#include "daemon/post/text_language.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Reads to the program's end. Moves in machine coordinates (G53, G28, SUPA, M91) leave the place unknown
/// until it is stated again; blocks begin where all five words are known. Errors: kInput as name:line:
/// another unit than the language's, arcs that are no part of a circle, cycles, incremental words, planes
/// that turn the rotaries by themselves, words that are not known or that would be misread (nc_rules.h),
/// another work offset behind the first block, a feed move without F or before all words are known, no block;
/// kLimit: more than the limits there.
Result<NcProgram> read_nc_program(std::istream& in, const std::string& name, const TextLanguage& language);

}  // namespace tiltfeed::daemon
