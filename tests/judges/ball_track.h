#pragma once
// The track of a ball's centre as a mesh, so that distances from a path are distances from a part.

#include <cstdint>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed {
using namespace pathgen;

/// Cutting moves only, as facets without area: they count by their edges.
inline Mesh ball_track(const ToolPath& path, double radius) {
  Mesh track;
  for (const Move& move : path.moves) {
    const auto v = static_cast<std::uint32_t>(track.vertices.size());
    track.vertices.push_back(move.pose.tip + move.pose.axis * radius);
    if (move.kind == MoveKind::kCut) track.facets.push_back({v - 1, v, v});
  }
  return track;
}

}  // namespace tiltfeed
