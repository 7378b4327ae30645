#pragma once
// Where a fit starts: shapes by linear least squares through few or all points, of which most points lie near
// the best. (H3) in pathgen/fit/README.md.

#include <cstdint>
#include <optional>
#include <span>

#include "pathgen/fit/curved_form.h"

namespace tiltfeed::pathgen {

/// A straight line in space.
struct Axis {
  Vec3 place;      ///< its point nearest to zero
  Vec3 direction;  ///< unit
};

/// (H4) The line that the normals of these points meet or run along, in the mean; nothing where any does, or
/// none.
std::optional<Axis> revolution_axis(std::span<const FitPoint> points);

/// Of the shapes through samples of the points, and through all, the one from which half of the points lie
/// nearest. Points about zero, some 1 apart. Nothing where the points are too special.
std::optional<Shape> start_of(FitKind kind, std::span<const FitPoint> points);

/// Fewest points of a sample that say the shape, and of a fit.
std::size_t sample_size(FitKind kind);

/// The k-th number of a sequence without pattern, the same on every machine.
class Sequence {
 public:
  std::uint32_t below(std::size_t limit) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>((state_ >> 33) % limit);
  }

 private:
  std::uint64_t state_ = 20051;
};

}  // namespace tiltfeed::pathgen
