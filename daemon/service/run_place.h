#pragma once
// Where the axes of a run are, and its overrides, for whoever asks.

#include <string>

#include "daemon/protocol/session.h"

namespace tiltfeed::daemon {

/// A JSON object: `program` (places by letters), `override` (percent by names), `words` (the machine's state
/// in words); each only where the controller has told it.
std::string run_place_json(const SendState& state);

}  // namespace tiltfeed::daemon
