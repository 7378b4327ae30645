#pragma once
// The tool as convex solids of revolution, and where lines of one direction run through them.
// (LE1) in pathgen/stock/README.md.

#include <limits>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/options/cutter.h"

namespace tiltfeed::pathgen {

/// Heights on a line, mm: low <= high.
struct LineSpan {
  double low = 0.0, high = 0.0;
};

/// Frusta on each other, rims from below, and a ball whose lowest point is the tip.
struct RoundSolid {
  struct Rim {
    double radius = 0.0, height = 0.0;  ///< over the tip, mm
  };
  ToolPart part = ToolPart::kCutter;
  double ball = 0.0;  ///< radius, mm; 0: none
  std::vector<Rim> rims;
  /// The outline of the whole tool, from the cutting part's lowest rim up to the axis.
  std::vector<Rim> outline;

  double lowest() const { return ball > 0.0 ? 0.0 : rims.front().height; }
  double highest() const { return rims.back().height; }
  double widest() const;
};

/// Cutter, shank, and the holder's steps, from below. A rounded edge is taken as a polygon within it: no more
/// than 0.9 % of its radius is missing.
std::vector<RoundSolid> round_solids(const Cutter& cutter);

/// A space axis as the direction of lines: a place is (u, v) across and t along it, mm.
struct LinePlace {
  double u = 0.0, v = 0.0, t = 0.0;
};
inline LinePlace line_place(Vec3 p, int along) {
  return along == 0 ? LinePlace{p.y, p.z, p.x}
                    : (along == 1 ? LinePlace{p.z, p.x, p.y} : LinePlace{p.x, p.y, p.z});
}

/// A solid at a pose, before lines along x, y or z (0, 1, 2).
class PlacedSolid {
 public:
  /// `solid` must outlive it.
  PlacedSolid(const RoundSolid& solid, const Pose& pose, int along);

  const RoundSolid& solid() const { return *solid_; }
  /// Nothing of it is beyond these.
  const LinePlace& low() const { return low_; }
  const LinePlace& high() const { return high_; }
  /// Where the line at (u, v) is in it; nothing: nowhere.
  std::optional<LineSpan> on_line(double u, double v) const;
  /// How deep a place in it is in the whole tool, mm: its distance from the outline, a ball's lower half left
  /// out. `enough`: what is no deeper need not be told right.
  double depth(LinePlace place, double enough = 0.0) const;
  /// May it meet the box? Never false where it does.
  bool may_meet(LinePlace low, LinePlace high) const;

 private:
  const RoundSolid* solid_;
  LinePlace tip_, axis_;
  LinePlace low_, high_;
};

}  // namespace tiltfeed::pathgen
