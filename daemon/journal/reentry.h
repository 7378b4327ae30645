#pragma once
// A program that enters another one in the middle: from wherever the tool stands, in the safe order, to the
// block before, and on from there.

#include <ostream>
#include <string>

#include "config/machine_profile.h"
#include "daemon/journal/reentry_text.h"
#include "daemon/program/link_kind.h"

namespace tiltfeed::daemon {

/// Order: retract along the tool axis from where the tool stands (where that is not reported, along the axis
/// of the block that is entered; a link of numeric blocks, which has no relative moves, needs the report), up
/// to the program's highest Z, rotaries as programmed, X Y above the entry, spindle and coolant, down to
/// `retract` above the entry, plunge along the axis, modal state, block `from` with all its words, the rest
/// unchanged. The preview names the tool that the program's newest change before `from` has put into the
/// spindle: none is changed on the way in. An axis that the program has sent to a place of the machine's own
/// (G53) goes there. The program is read three times, and not kept. Over DNC to a Fanuc or Haas the order is
/// that of plan_control_entry(). Errors: kUsage (no such block; block 1
/// needs no re-entry; no place on such a link, or an axis whose place the program has not said), kInput (a
/// line that is not understood: then nobody can say what is in force), kLimit (a step leaves the travel).
Result<Reentry> plan_reentry(const std::string& program, LinkKind kind, const config::MachineProfile& machine,
                             const ReentryOptions& options);
/// The whole text: the head, then what follows in the program. Errors: kIo, kInput.
Result<void> write_reentry(const std::string& program, const Reentry& entry, std::ostream& out);

}  // namespace tiltfeed::daemon
