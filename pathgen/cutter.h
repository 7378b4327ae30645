#pragma once

namespace tiltfeed {

/// A ball end mill with a straight shank of the ball's diameter, up to the holder.
struct Cutter {
  double diameter = 0.0;      ///< mm
  double length = 0.0;        ///< gauge line to tip, mm
  double shank_length = 0.0;  ///< tip to holder, mm; the shank is checked against the part that far up
  double radius() const { return diameter / 2.0; }
};

}  // namespace tiltfeed
