#pragma once
// An arc as it is printed.

#include <cstddef>
#include <cstdint>

#include "kinematics/machine/machine_model.h"

namespace tiltfeed::daemon {

struct PrintedArc {
  std::size_t block = 0;         ///< of the operation's words: the arc goes from the one before to it
  std::uint32_t stands_for = 0;  ///< straight blocks
  int plane = 17;                ///< 17: X Y, 18: Z X, 19: Y Z, as first and second axis
  bool clockwise = false;        ///< as seen from the positive end of the third axis
  // The centre from the start, along the first and the second axis, mm, as the words say it.
  double first = 0.0, second = 0.0;
  double length = 0.0;  ///< of the way, mm
};

/// The axes of an arc's plane. Property: first, second and third make a right-handed frame.
struct ArcAxes {
  double Joints::*first, Joints::*second, Joints::*third;
};
constexpr ArcAxes arc_axes(int plane) {
  if (plane == 18) return {&Joints::z, &Joints::x, &Joints::y};
  if (plane == 19) return {&Joints::y, &Joints::z, &Joints::x};
  return {&Joints::x, &Joints::y, &Joints::z};
}

}  // namespace tiltfeed::daemon
