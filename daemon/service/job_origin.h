#pragma once
// One block of a job, back to its line, its move of the tool path and the facet of the part.

#include <cstdint>
#include <string>

#include "config/machine_profile.h"
#include "daemon/wire/link.h"

namespace tiltfeed::daemon {

/// A JSON object. `program` and `map` are files; what they cannot tell is left out or said as "error".
std::string origin_json(const std::string& program, const std::string& map, LinkKind kind,
                        const config::MachineProfile& machine, std::uint64_t number);

}  // namespace tiltfeed::daemon
