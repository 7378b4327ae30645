#pragma once
// Which Tiltfeed this is.

#include <string>

namespace tiltfeed::config {

/// "0.1.0 (commit 1a2b3c4d)"; "changed" behind the commit where the sources differ from it; without commit
/// where the sources are no checkout.
std::string version();

}  // namespace tiltfeed::config
