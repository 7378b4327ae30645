#pragma once
// Kinks of the CL surface along a flat line: where the tool touches the part at two places at once. (CR1) in
// pathgen/creases/README.md.

#include <array>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

struct KinkOptions {
  Angle least_angle = Angle::from_degrees(10.0);  ///< between the normals of the CL surface on both sides
  double least_cliff = 0.01;                      ///< a step of the CL surface that is lower is rounding, mm
};

/// Both sides of a kink are known at places so near to each other, mm of the flat plane.
inline constexpr double kKinkStep = 1e-6;
/// A CL surface that climbs by more than this a mm is steep: beside it a pass keeps to the other side.
inline constexpr double kSteepSide = 1.5;

struct Kink {
  double run = 0.0;               ///< along the line, mm
  EnvelopePoint point;            ///< of the lower side where there is a cliff, else of either
  std::array<double, 2> aside{};  ///< unit, flat: roughly across the crease, to the side that climbs less
  bool steep = false;             ///< the other side is steep, or a cliff
};

/// The envelope must outlive it; one object a thread.
/// Properties: 1 A kink's place is within kKinkStep of one where two patches of the cutting part, whose
/// normals differ by the least angle, are equally high; or where the envelope drops by the least cliff. 2 The
/// surface is concave there. 3 None is missed between two points of Envelope::along whose normals differ by
/// the least angle.
class KinkSearch {
 public:
  KinkSearch(const ClField& field, Envelope& envelope, const KinkOptions& options)
      : field_(field), envelope_(envelope), options_(options) {}

  /// By rising run. Contacts of shank, holder and fixtures make no kinks.
  std::vector<Kink> along(const FlatLine& line);

 private:
  void search(const FlatLine& line, double from, const EnvelopePoint& a, double to, const EnvelopePoint& b,
              std::vector<Kink>& kinks);
  void judge(const FlatLine& line, double run, const EnvelopePoint& a, const EnvelopePoint& b,
             std::vector<Kink>& kinks) const;
  bool may_kink(const EnvelopePoint& a, const EnvelopePoint& b) const;

  const ClField& field_;
  Envelope& envelope_;
  KinkOptions options_;
};

}  // namespace tiltfeed::pathgen
