#pragma once
// Lines that a profile puts before a program's first motion: the words that leave those of the program as
// they are meant. A control knows far more; what is not in the list is refused.

#include <optional>
#include <string>

#include "config/program_format.h"

namespace tiltfeed::config {

/// Nothing where each word of the line is known to leave the words of the program as they are meant on this
/// control: exact stop, blending, smoothing and look-ahead, work offsets, planes, what cancels, moves in
/// machine coordinates, M codes that neither call nor end nor turn the spindle. Else the first that is not.
/// Requires: what moves_the_tool() and breaks_words() refuse has been.
std::optional<std::string> unknown_before_motion(const std::string& line, Dialect dialect);

}  // namespace tiltfeed::config
