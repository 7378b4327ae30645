#pragma once
// Lines of a program that a profile states: what they may not do to the words that follow.

#include <optional>
#include <string>
#include <vector>

#include "config/program_format.h"

namespace tiltfeed::config {

/// The line without what stands in parentheses: comments and arguments.
std::string bare(const std::string& line);
/// Its axes go to places of the machine's own, or to a reference point.
bool in_machine_coordinates(const std::string& line);
/// Words that move an axis in the part's coordinates; those of a move in the machine's own do not count.
bool moves_the_tool(const std::string& line);

/// What such lines, run one after the other in G90 and mm, break; nothing: they may stand there.
/// `before_motion`: the program's words follow. Refused: a reference point by way of a place of the part (G28
/// X0 without G91), G91 that nothing ends, and before motion inches, the program's end, TCP and tilted
/// planes.
std::optional<std::string> breaks_words(const std::vector<std::string>& lines, bool before_motion);

/// Why the line does not take the tool off along the machine's Z; nothing: it does.
std::optional<std::string> no_retract(const std::string& line, Dialect dialect);

}  // namespace tiltfeed::config
