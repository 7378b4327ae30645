#pragma once
// A line of program text without what stands round its words, and the header that comments make.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/program_format.h"
#include "daemon/post/nc_program.h"

namespace tiltfeed::daemon {

/// Takes comments, the block's number and its end off; the comments' texts are appended. Returns what is
/// wrong.
std::optional<std::string> strip_line(std::string& line, config::Dialect dialect,
                                      std::vector<std::string>& comments);

/// "TILTFEED ..." of a posted program's header goes into `program`; other comments say nothing. A tool's
/// length behind blocks begins another operation. Requires: an operation.
void take_header(std::string_view comment, NcProgram& program);

}  // namespace tiltfeed::daemon
