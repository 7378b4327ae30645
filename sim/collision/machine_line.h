#pragma once
// A machine as a line of links, from the work to the tool: what each axis moves, bed and slides included.
// Independent of kinematics/machine/machine.cpp. Formula (CO2) is in sim/collision/README.md.

#include <array>
#include <vector>

#include "config/machine_profile.h"
#include "sim/collision/body_tree.h"

namespace tiltfeed::sim {

/// Axis words in the order x, y, z, tilt, rotary; mm and degrees.
using AxisWords = std::array<double, 5>;
constexpr AxisWords words_of(const Joints& j) { return {j.x, j.y, j.z, j.a, j.c}; }
inline constexpr std::size_t kTiltAxis = 3, kRotaryAxis = 4;

/// Joint between a link and the next one towards the tool, all axes at home and the gauge line at machine
/// zero.
struct LineJoint {
  std::size_t axis = 0;  ///< of AxisWords
  Vec3 point, direction;
  double factor = 1.0;  ///< of what the link beyond it does, against its word
  double home = 0.0;    ///< the word, or of a slide less than the word is where it stands
  bool turns() const { return axis >= kTiltAxis; }
};

class MachineLine {
 public:
  MachineLine(const config::MachineProfile& machine, const Setup& setup);

  /// The link, counted from that of the work.
  int link(config::BodyLink body) const;
  int work() const { return 0; }
  int tool() const { return static_cast<int>(joints_.size()); }
  /// Where the coordinates of a body of that link start.
  Vec3 origin(config::BodyLink body) const;
  /// Part and tool coordinates at home: p -> placement(p).
  Placement part() const { return {fixture_, zero_}; }
  Placement tip() const;
  Vec3 table() const { return centre_; }

  /// (CO2) What belongs to the link `to`, as the link `from` sees it. Requires: from <= to.
  Placement relative(const AxisWords& words, int from, int to) const;
  /// Joint k is between the links k and k + 1.
  const std::vector<LineJoint>& joints() const { return joints_; }

 private:
  void add_slides(const std::vector<int>& axes, bool work);
  void add_rotary(const RotaryAxis& axis, std::size_t index, Vec3 point, bool work);

  std::vector<LineJoint> joints_;
  std::array<int, 3> slide_link_{};
  int bed_ = 0;
  Structure structure_;
  Vec3 centre_, zero_, home_, gauge_to_tip_, spindle_;
  Rotation fixture_;
};

}  // namespace tiltfeed::sim
