#pragma once
// How large a part is, and whether that can be meant.

#include <optional>
#include <string>

#include "config/job.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

/// "part 100 x 80 x 40 mm".
std::string size_text(const pathgen::Box& bounds);

/// A warning where the part is smaller than a few cutters or larger than the machine's travels: with the unit
/// of part.unit that would make sense, if one does.
std::optional<std::string> unit_warning(const pathgen::Box& bounds, const config::Job& job);

}  // namespace tiltfeed::daemon
