#pragma once
// APT words that the reader does not act on: which only inform, which ask for what it cannot do, and which
// may be a misspelt motion.

#include <optional>
#include <string>

#include "kinematics/cl_text/apt_record.h"

namespace tiltfeed {

/// The word informs people or other programs, or ends what was never begun.
bool only_informs(const AptRecord& record);

/// Why a record that the reader does not act on must not be left out: it asks for another motion than the
/// points that follow, it is a part program's and no CL record, or it looks like a motion word misspelt.
/// Nothing: it may be left out with a note.
AptVerdict must_not_be_dropped(const AptRecord& record);

/// A word without which no point is where the file means it: no option leaves it out.
bool is_motion_word(const std::string& word);

}  // namespace tiltfeed
