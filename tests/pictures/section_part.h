#pragma once
// A small part of few facets whose section at y = 0 shows every kind of feature, and its CL surface.

#include <memory>

#include "pathgen/mesh/mesh.h"
#include "pathgen/surface/cl_field.h"
#include "tests/pictures/svg.h"

namespace tiltfeed::pictures {
using namespace pathgen;

/// The outline of a section extruded along y, from (x, z) to (x, z), with its bottom at kBottom; on the flat
/// stretch from kPeakFrom to kPeakTo stands a pyramid with its tip at y = 0.
Result<CheckedMesh> section_part(const Line& outline, bool with_peak);
/// The one that the pictures of the CL surface and of the envelope show.
Result<CheckedMesh> section_part();
/// Its section at y = 0, from left to right.
Line section_outline();

inline constexpr double kBottom = -4.0, kPeakFrom = 6.0, kPeakTo = 18.0, kPeakHeight = 7.0;
inline constexpr double kBall = 3.0;  ///< radius of the tool, mm

/// The field of a ball of radius kBall, its axis upright.
struct SectionField {
  CheckedMesh part;
  std::unique_ptr<const ClField> field;
};
Result<std::unique_ptr<SectionField>> section_field();

/// Part, axes and what a millimetre is: the ground that the pictures stand on.
Plot section_plot(Svg& svg, At corner);

}  // namespace tiltfeed::pictures
