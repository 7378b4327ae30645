#pragma once
// The tool: a solid of revolution about its axis, from the tip up to and including the holder.

#include <vector>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

enum class ToolPart { kCutter, kShank, kHolder };

enum class CutterType {
  kBall,      ///< a ball end of `diameter`
  kBullNose,  ///< `diameter` with the edge rounded by `corner_radius`
  kFlat,      ///< `diameter` with a sharp edge
  kTaperBall  ///< a ball of `diameter`, tangent to a cone of half-angle `taper` that widens upwards
};

/// A step of the holder: a cone frustum about the axis. Steps stand on each other, the first on the shank.
struct HolderStep {
  double lower_diameter = 0.0, upper_diameter = 0.0, length = 0.0;  ///< mm
};

/// From the tip up: the cutting part (up to cutting_length), the shank (up to shank_length), the holder.
/// Properties of a cutter that a job states: 1 nose_radius() <= radius(). 2 0 < cutting_end() <= shank_length
/// <= length. 3 Shank and holder are wider than 0 everywhere. 4 cutting_top_radius() is that of a cone
/// tangent to the ball, at cutting_end(): within 1e-12 mm.
struct Cutter {
  double diameter = 0.0;      ///< of the cutting part, mm; of a taper ball: of the ball
  double length = 0.0;        ///< gauge line to tip, mm
  double shank_length = 0.0;  ///< tip to holder, mm
  CutterType type = CutterType::kBall;
  double corner_radius = 0.0;        ///< bull-nose only, mm
  Angle taper{};                     ///< half-angle of the cone; taper ball only
  double cutting_length = 0.0;       ///< tip to where the shank starts, mm; 0: shank_length
  double shank_diameter = 0.0;       ///< mm; 0: as wide as the top of the cutting part
  std::vector<HolderStep> holder{};  ///< empty: nothing is known, and nothing checked, above shank_length

  double radius() const { return diameter / 2.0; }
  /// Radius of the rounded edge, mm: 0 for a flat end.
  double nose_radius() const {
    switch (type) {
      case CutterType::kBullNose:
        return corner_radius;
      case CutterType::kFlat:
        return 0.0;
      default:
        return radius();
    }
  }
  /// Where the cutting part ends, mm above the tip.
  double cutting_end() const { return cutting_length > 0.0 ? cutting_length : shank_length; }
  /// Radius at the top of the cutting part, mm: a taper ball is wider there than its ball.
  double cutting_top_radius() const;
  /// Radius of the shank, mm.
  double shank_radius() const { return shank_diameter > 0.0 ? shank_diameter / 2.0 : cutting_top_radius(); }
};

}  // namespace tiltfeed::pathgen
