#pragma once
// Creases of the CL surface as curves: where the tool, let down, touches the part at two places. (CR4) in
// pathgen/creases/README.md.

#include <vector>

#include "pathgen/creases/crease_graph.h"

namespace tiltfeed::pathgen {

/// From end to end; a closed one ends with its first node.
using Crease = std::vector<CreaseNode>;

/// The pieces of the graph, put together. Properties: 1 No crease goes on through a place where three meet.
/// 2 Places within `gap` (mm) of each other where creases end or meet are one. 3 None that has a free end, or
/// comes back to its start, is shorter than `least_length` (mm of the CL reference). 4 Each piece is in one
/// crease, but for those left out by 2 and 3.
std::vector<Crease> joined_creases(const CreaseGraph& graph, double gap, double least_length);

/// Length of the CL reference's way, mm.
double crease_length(const Crease& crease);

}  // namespace tiltfeed::pathgen
