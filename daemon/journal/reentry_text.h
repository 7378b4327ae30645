#pragma once
// What a re-entry is made from, and its text.

#include <cstdint>
#include <optional>
#include <string>

#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

struct ReentryOptions {
  std::uint64_t from = 0;      ///< first block that is executed again, counted from 1
  double retract = 50.0;       ///< up the tool axis, first of all, and the height that is plunged at last, mm
  double plunge_feed = 200.0;  ///< mm/min
  double spindle_delay = 3.0;  ///< seconds until the spindle turns
  Setup setup;                 ///< of the job; where it is not known, of a tool without length
  /// Where the axes are, as the controller reports it: the retract is along the axis that the tool has there.
  std::optional<Joints> stands = {};
};

struct Reentry {
  std::string head;        ///< of the program, up to and with the first line of the one that is entered
  std::string preview;     ///< what happens before the first block, a line each, for the operator
  std::uint64_t line = 0;  ///< of the file, that the head ends with
  /// The moves of the way in alone, in words of places, for who holds them against what stands about: `from`
  /// states where the machine stands and goes off from there (empty: it does not say), `held` the rest.
  std::string from, held;
  bool as_it_stands = false;  ///< the lines behind it keep their blanks and comments
};

}  // namespace tiltfeed::daemon
