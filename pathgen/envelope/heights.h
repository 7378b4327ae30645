#pragma once
// Heights of the envelope as a function on the whole flat plane, also where there is no surface.

#include <limits>
#include <optional>
#include <vector>

#include "pathgen/envelope/envelope.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// A place of the flat plane (x', y'), mm.
struct Place {
  double x = 0.0, y = 0.0;
};
inline Place lerp(Place a, Place b, double f) { return {a.x + (b.x - a.x) * f, a.y + (b.y - a.y) * f}; }
inline double distance(Place a, Place b) { return std::hypot(b.x - a.x, b.y - a.y); }

/// The height where the axis line meets no surface: the tool may go down as far as it likes.
inline constexpr double kNoSurface = -std::numeric_limits<double>::infinity();
/// The height where the tool may not be at all: the column is shut at its end.
inline constexpr double kShut = std::numeric_limits<double>::infinity();

struct HeightSample {
  double run = 0.0, z = kNoSurface;
};

/// One object a thread; the field must outlive it.
class Heights {
 public:
  Heights(const ClField& field, const EnvelopeOptions& options)
      : map_(field.deformation), envelope_(field.surface, field.deformation, field.index, options) {}

  /// z' of the envelope, kNoSurface or kShut. Beyond a pole of the mode point: that of the same axis line on
  /// the near side.
  double at(Place p);

  /// Is that over `z`? Requires: a level that a contour may have there, kLeastAxisDistance off the axis
  /// feature.
  bool is_over(Place p, double z);

  /// Is that of the cutting part alone? Without shank, holder and fixtures: the same as is_over().
  bool cut_is_over(Place p, double z);

  /// The envelope's point there; where there is none, one without height, with the patch that shuts the
  /// column, if any.
  EnvelopePoint contact(Place p);

  /// Is z' at most `top` on the straight line from a to b, which does not run beyond a pole? `points` becomes
  /// the envelope there; where shank and holder stay under `top`, that of the cutting part.
  bool keeps_under(double top, Place a, Place b, Pass& points);

  /// Heights along the line by rising run, as densely as Envelope::along gives them; gaps are samples of
  /// kNoSurface or kShut just beyond the ends of what is beside them.
  /// Shank and holder are asked for only where they may be higher than `z`.
  std::vector<HeightSample> profile(const FlatLine& line, double z = kNoSurface);

  Envelope& envelope() { return envelope_; }
  const Deformation& map() const { return map_; }

 private:
  Place folded(Place p) const;
  bool may_be_shut() const;

  const Deformation& map_;
  Envelope envelope_;
};

/// The level at which the envelope is crossed between `outside` (at most as high) and `inside` (higher),
/// moved together on their straight line until they are at most `fineness` apart.
void bisect(Heights& heights, double level, double fineness, Place& outside, Place& inside);

/// The straight line from a to b.
FlatLine line_between(Place a, Place b);

}  // namespace tiltfeed::pathgen
