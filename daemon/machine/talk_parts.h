#pragma once
// What the conversations with controllers have in common.

#include <cstddef>

#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// Lines that are kept.
inline constexpr std::size_t kMostReplies = 4096;

inline tl::unexpected<Error> cancelled() { return fail(Code::kCancelled, "stopped on request"); }

}  // namespace tiltfeed::daemon
