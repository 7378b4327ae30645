#pragma once
// Which facets a plan leaves uncut, from its report.

#include <cstdint>
#include <istream>
#include <string>
#include <vector>

#include "kinematics/result.h"

namespace tiltfeed::sim {

/// Numbers of STL facets, ascending, each once: those under uncut.facets, by half at least, and
/// free.unreached_facets of the report of `tiltfeed plan`. Errors: kInput when it is no such report.
Result<std::vector<std::uint32_t>> read_uncut_facets(std::istream& in, const std::string& path);

}  // namespace tiltfeed::sim
