#pragma once
// Planes, circles, spheres, cylinders and tori through points of a part, by least squares of the orthogonal
// distance. (H1)..(H4) in pathgen/fit/README.md.

#include <cstdint>
#include <span>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/fit/fitted_shape.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

struct FitOptions {
  /// Points that lie further off than four standard deviations, as the nearer half of all scatters, are left
  /// out. Up to about a third of the points may be.
  bool leave_outliers = true;
};

/// Fewest points: a plane 3, circle 4, sphere 5, cylinder 6, torus 8. The same for the same points, whatever
/// the machine.
/// Errors: kInput: too few points, no normals, or the points do not say what is asked (those of a plane no
/// sphere of at most kMostRadius).
Result<Fit> fit(FitKind kind, std::span<const FitPoint> points, const FitOptions& options = {});

/// A radius beyond this is a plane's, mm.
inline constexpr double kMostRadius = 1e8;

/// The corners of these facets, each once, for the area of theirs that is its; normals likewise.
/// Corners lie on the surface that the mesh was made of; middles of facets are off it by the chords' height.
std::vector<FitPoint> corners_of(const Mesh& mesh, std::span<const std::uint32_t> facets);

}  // namespace tiltfeed::pathgen
