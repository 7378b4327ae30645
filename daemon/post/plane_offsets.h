#pragma once
// Work offsets of tilted planes: each place of the rotaries has one of its own, so that the operator can
// correct each plane by itself.

#include <string>
#include <vector>

#include "daemon/post/posting.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Of the planes of a posting, by rising offset: in the order in which they come first. A place that comes
/// again, a turn further on too, has the offset that it had. Empty: the posting's data ask for none.
/// Errors: kInput: an operation is in no tilted plane. kLimit: the control cannot call so many.
Result<std::vector<PlaneOffset>> plane_offsets(const Posting& posting);

/// The offset of an operation among these; without any the program's own. Requires: plane_offsets() of its
/// posting.
int offset_of(const std::vector<PlaneOffset>& planes, const Posting& posting, const Operation& op);

/// What the program's header says of them; nothing where there are none.
std::vector<std::string> offset_remarks(const std::vector<PlaneOffset>& planes,
                                        const config::MachineProfile& machine);

}  // namespace tiltfeed::daemon
