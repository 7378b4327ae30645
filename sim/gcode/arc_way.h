#pragma once
// The way of an arc (G2, G3) as a control goes it: from its start round the centre to its end. Shares nothing
// with the post that fitted it.

#include <optional>
#include <string>

#include "kinematics/machine/machine.h"

namespace tiltfeed::sim {

/// The straight pieces of an arc leave it by no more than this, mm.
inline constexpr double kArcChord = 1e-4;
/// The radius at the end of an arc differs by no more than this from that at its start, mm: what is more some
/// controls refuse. Grbl: 0.005; a Sinumerik: 0.01; LinuxCNC: 0.028.
inline constexpr double kArcRadiusError = 0.005;

struct ArcWords {
  int plane = 17;                    ///< 17: X Y, 18: Z X, 19: Y Z, as first and second axis
  bool clockwise = false;            ///< G2: as seen from the positive end of the third axis
  double first = 0.0, second = 0.0;  ///< the centre's place along these axes, mm
};

/// The axes of a plane. Property: first, second and third make a right-handed frame.
struct ArcPlane {
  double Joints::*first, Joints::*second, Joints::*third;
  char letters[3];  ///< of these axes
  char centre[3];   ///< of I J K for these
};
const ArcPlane& arc_plane(int plane);

/// Properties: 1 the radius grows evenly from that of the start to that of the end. 2 at(1) is `to`, to the
/// last bit. 3 Chords between at(i / pieces()) leave the way by at most kArcChord.
class ArcWay {
 public:
  /// Requires: arc_is_wrong() says nothing.
  ArcWay(const Joints& from, const Joints& to, const ArcWords& words);

  Joints at(double share) const;
  int pieces() const;
  double length() const;  ///< mm
  double turn() const;    ///< round the centre, radians, above 0

 private:
  const ArcPlane& plane_;
  Joints from_, to_;
  double first_, second_, radius_, growth_, begin_, sweep_;
};

/// Why a control refuses the arc; nothing: it does not.
std::optional<std::string> arc_is_wrong(const Joints& from, const Joints& to, const ArcWords& words);

}  // namespace tiltfeed::sim
