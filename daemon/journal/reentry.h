#pragma once
// A program that enters another one in the middle: from wherever the tool stands, in the safe order, to the
// block before, and on from there.

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>

#include "config/machine_profile.h"
#include "daemon/wire/link.h"

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
};

/// Order: retract along the tool axis from where the tool stands (where that is not reported, along the axis
/// of the block that is entered; a link of numeric blocks, which has no relative moves, needs the report), up
/// to the program's highest Z, rotaries as programmed, X Y above the entry, spindle and coolant, down to
/// `retract` above the entry, plunge along the axis, modal state, block `from` with all its words, the rest
/// unchanged. The preview names the tool that the program's newest change before `from` has put into the
/// spindle: none is changed on the way in. An axis that the program has sent to a place of the machine's own
/// (G53) goes there. The program is read three times, and not kept. Errors: kUsage (no such block; block 1
/// needs no re-entry; no place on such a link, or an axis whose place the program has not said), kInput (a
/// line that is not understood: then nobody can say what is in force), kLimit (a step leaves the travel).
Result<Reentry> plan_reentry(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                             const ReentryOptions& options);
/// The whole text: the head, then what follows in the program. Errors: kIo, kInput.
Result<void> write_reentry(const std::string& program, const Reentry& entry, std::ostream& out);

}  // namespace tiltfeed::daemon
