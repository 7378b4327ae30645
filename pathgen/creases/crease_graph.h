#pragma once
// The creases of the CL surface over a rectangle of the flat plane, as a graph: places, and the pieces of
// crease between them. (CR2), (CR3) in pathgen/creases/README.md.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/creases/kinks.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

struct CreaseOptions {
  EnvelopeOptions envelope;
  KinkOptions kinks;
  double spacing = 1.0;  ///< of the grid's lines, mm of the flat plane: a crease that meets none is missed
  double chord = 0.001;  ///< of a piece off the crease, mm of the CL reference
};

struct CreaseNode {
  EnvelopePoint point;
  std::array<double, 2> aside{};  ///< as Kink
  bool steep = false;
};

struct CreaseGraph {
  std::vector<CreaseNode> nodes;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pieces;
};

/// Most lines of the grid to either side.
inline constexpr double kMostCreaseLines = 20e3;

/// Properties: 1 Every node is a kink. 2 Half way along a piece the crease is at most `chord` off. 3 Where
/// three creases meet, their pieces end within kLeastCreaseCell of each other. 4 The same on any number of
/// threads. Errors: kLimit for too fine a grid; kCancelled.
Result<CreaseGraph> trace_crease_graph(const ClField& field, const FlatBounds& bounds,
                                       const CreaseOptions& options, const Progress& progress);

/// Cells of the grid are quartered down to this (mm of the flat plane) where creases meet or end.
inline constexpr double kLeastCreaseCell = 2e-3;

}  // namespace tiltfeed::pathgen
