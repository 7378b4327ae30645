#pragma once
// Stretches of a way that need not be looked at for the nearest.

namespace tiltfeed {

/// Whether both ends of a segment, a and b along an axis, lie further than `least` from p to one side.
inline bool lies_aside(double p, double a, double b, double least) {
  return (a - p > least && b - p > least) || (p - a > least && p - b > least);
}

}  // namespace tiltfeed
