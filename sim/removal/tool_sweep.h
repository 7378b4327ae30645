#pragma once
// The whole tool between two poses, as convex bodies.

#include <array>
#include <cstdint>
#include <vector>

#include "config/job.h"
#include "sim/removal/swept_body.h"

namespace tiltfeed::sim {

/// The unit axis half way between two poses'.
Vec3 mean_axis(const Pose& a, const Pose& b);
/// The place on the tool's axis so high over the tip, mm.
inline Point<Part> on_axis(const Pose& p, double height) { return p.tip + p.axis * height; }

/// Which of the cubes of a side, mm, that fill the space: places in the same one are near each other.
using Cube = std::array<std::int64_t, 3>;
Cube cube_at(Point<Part> p, double side);

/// Which bodies the cutter, shank and holder of a job sweep. (W4) Each piece is pushed along the way of its
/// own middle, with the mean of both axes: right for a turn of the axis too, as far as the piece is short.
class ToolSweep {
 public:
  explicit ToolSweep(const pathgen::Cutter& cutter);

  /// Appends the bodies of the cutter between two poses: short pieces of it, from the tip up; of a round one
  /// only those of which clear(middle) is below 0. Else it says how far round that point it would be no
  /// other, mm.
  template <class Clear>
  void cutter_bodies(const Pose& from, const Pose& to, const Clear& clear, std::vector<SweptBody>& out) const;
  /// Appends those of shank and holder, from below.
  void rest_bodies(const Pose& from, const Pose& to, std::vector<SweptBody>& out) const;
  /// All of a piece is within this, and half its way, of its middle, mm.
  double piece_reach() const { return 0.5 * step_ + reach_; }
  /// The piece of the cutting part that is next to p.
  SweptBody cutter_near(const Pose& from, const Pose& to, Point<Part> p) const;

  bool round() const { return round_; }  ///< a ball end: its cutting part is all within reach() of its core
  /// The cutting part's axis, from the lowest point that is `reach` inside of it to its end, above the tip,
  /// mm.
  double core_low() const { return core_low_; }
  double core_high() const { return core_high_; }
  /// Length of the longest piece that is swept as one, mm.
  double longest() const { return longest_; }
  double reach() const { return reach_; }  ///< the cutting part is within this of its core, mm

 private:
  SweptBody piece(const Pose& from, const Pose& to, double low, double high) const;
  void solid_bodies(ToolPart part, const Pose& from, const Pose& to, std::vector<SweptBody>& out) const;

  ToolSolid solid_;
  bool round_;  ///< a ball end: its cutting part is a capsule
  double core_low_, core_high_, reach_, step_, longest_ = 0.0;
};

template <class Clear>
void ToolSweep::cutter_bodies(const Pose& from, const Pose& to, const Clear& clear,
                              std::vector<SweptBody>& out) const {
  if (!round_) return solid_bodies(ToolPart::kCutter, from, to, out);
  double clear_to = -kInfinity;  // up to this height; points up the tool are no further apart than heights
  const auto add = [&](double low, double high) {
    const double h = 0.5 * (low + high);
    if (h < clear_to) return;
    if (const double mm = clear(lerp(from.tip + from.axis * h, to.tip + to.axis * h, 0.5)); mm >= 0.0) {
      clear_to = h + mm;
      return;
    }
    out.push_back(piece(from, to, low, high));
    if (low == core_low_ && high > low) out.back() = out.back().without_ball();
  };
  // The ball by itself: its way is exact.
  add(core_low_, core_low_);
  for (double low = core_low_; low < core_high_; low += step_) add(low, std::min(core_high_, low + step_));
}

}  // namespace tiltfeed::sim
