#pragma once
// The shop, looked at again and again, for a page that shows it.

#include <string>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Until the standard output is closed, or a signal. About every 3 s, and sooner when jobs come, a line on
/// the standard output: {"version", "state", "error"}; state is `up`, or `lost` with the error. Each version
/// is in `file`, whole: what `tiltfeed shop list --json` prints, but the times that change without news; with
/// the jobs that ended in the last day. A lost connection is tried again. Errors: kInput (the address), kIo
/// (the file).
Result<void> watch_shop(const std::string& url, const std::string& file);

}  // namespace tiltfeed::daemon
