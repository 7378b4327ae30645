#pragma once
// Large planes and cylinders: faces that are cut in many set-ups, or hold the part. (Q6) in
// pathgen/suggest/README.md.

#include <span>
#include <vector>

#include "pathgen/reach/reach_scene.h"
#include "pathgen/suggest/feature.h"

namespace tiltfeed::pathgen {

/// How much each of the places counts, mm^2: its area, or kPlainShare of that on a plain face; all their area
/// where hardly anything else is. `size`: of the part, mm.
std::vector<double> weights_of(const Mesh& mesh, std::span<const ReachPlace> places,
                               std::span<const Feature> features, double size);

/// What a plain face counts for, of its area.
inline constexpr double kPlainShare = 0.02;

}  // namespace tiltfeed::pathgen
