#pragma once
// What a machine command works with, and what it answers.

#include <functional>
#include <string>

#include "config/machine_profile.h"
#include "daemon/wire/link.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::daemon {

/// What a command works with.
struct MachineBench {
  const config::MachineProfile& machine;
  const LinkSpec& link;
  Link& wire;
  Clock& clock;
  /// The operator wants no more: a motion is ended.
  std::function<bool()> stopped = [] { return false; };
  /// A continuous jog goes on as long as this is true: somebody holds the key.
  std::function<bool()> held = [] { return false; };
};

/// `text`: lines for people. `json`: the same as one object.
struct MachineAnswer {
  std::string text, json;
};

/// What is wrong with the words of a command, and which it takes.
tl::unexpected<Error> wrong_words(const char* command, const std::string& what);

}  // namespace tiltfeed::daemon
