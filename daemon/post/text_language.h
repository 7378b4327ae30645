#pragma once
// What a reader of program text needs to know of the control.

#include <string>
#include <vector>

#include "config/program_format.h"
#include "kinematics/machine/machine_model.h"

namespace tiltfeed::daemon {

/// A rotary of the table: its letter, and its word at home.
struct TableLetter {
  char letter = 'C';
  double home = 0.0;
};

/// What the reader needs to know of the control.
struct TextLanguage {
  config::Dialect dialect = config::Dialect::kRs274;
  char tilt = 'A', rotary = 'C';
  RotaryWord tilt_word = RotaryWord::kAccumulate, rotary_word = RotaryWord::kAccumulate;
  bool inches = false;                  ///< the unit of the linear words
  std::vector<int> own_codes = {};      ///< M codes of the machine's own lines
  std::vector<TableLetter> table = {};  ///< rotaries that carry the work
  std::string through_on = {};          ///< the profile's line for coolant through the spindle; empty: none
  std::string swivel_data = {};         ///< the name that CYCLE800 has to call; empty: any
  std::vector<std::string> other_axes =
      {};  ///< the profile's own lines that move U, V or W, axes beside ours
};

}  // namespace tiltfeed::daemon
