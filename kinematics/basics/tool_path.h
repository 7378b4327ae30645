#pragma once
// The tool path in part coordinates: what pathgen makes, the post consumes and the CL file holds.

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/units.h"

namespace tiltfeed {

/// A place and orientation of the tool in part coordinates.
struct Pose {
  Point<Part> tip;  ///< the tool tip (for a ball end: the ball's lowest point, not its centre), mm
  Vec3 axis;        ///< unit, from the tip to the shank
  constexpr bool operator==(const Pose&) const = default;
};

/// How a move is travelled; it picks the feed.
enum class MoveKind : std::uint8_t {
  kRapid,   ///< in clear air, as fast as the axes go
  kPlunge,  ///< towards the part, at plunge feed
  kCut,     ///< in contact, at cutting feed
};

inline constexpr std::uint32_t kNoFacet = 0xFFFFFFFF;

/// A straight move of the tip to `pose`, while the axis turns on the great circle, from the pose before.
struct Move {
  Pose pose;
  MoveKind kind = MoveKind::kRapid;
  std::uint32_t facet = kNoFacet;  ///< the STL facet that the tool touches at the end of the move
};

/// The tool, as the CL file and the program header state it.
struct ToolData {
  double diameter = 0.0;       ///< mm
  double corner_radius = 0.0;  ///< mm; diameter / 2 for a ball end
  double length = 0.0;         ///< gauge line to tip, mm
  constexpr bool operator==(const ToolData&) const = default;
};

/// A feed other than the path's two: that of all feed moves from this one on.
struct FeedChange {
  std::uint32_t move = 0;  ///< index into ToolPath::moves
  Feed feed;
};

/// Properties: the first move is a rapid that only states the start pose; every axis is unit to 1e-12.
struct ToolPath {
  std::string name;  ///< of the part; ASCII [A-Za-z0-9 ._-]
  ToolData tool;
  Feed cut_feed, plunge_feed;
  std::vector<Move> moves;
  std::vector<FeedChange> feeds;  ///< by rising move; empty: cut_feed and plunge_feed by the kind of move
};

/// The feed of a feed move.
inline Feed feed_of(const ToolPath& path, std::size_t move) {
  const auto after =
      std::upper_bound(path.feeds.begin(), path.feeds.end(), move,
                       [](std::size_t m, const FeedChange& change) { return m < change.move; });
  if (after != path.feeds.begin()) return std::prev(after)->feed;
  return path.moves[move].kind == MoveKind::kPlunge ? path.plunge_feed : path.cut_feed;
}

}  // namespace tiltfeed
