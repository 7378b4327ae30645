#pragma once
// How the part is turned and put on the table so that the machine's axes reach most of what the rays reach.
// (Q4) in pathgen/suggest/README.md.

#include <optional>
#include <span>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/machine/machine_model.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/reach/machine_reach.h"

namespace tiltfeed::pathgen {

/// A pose that cuts an area.
struct CutPose {
  Pose pose;
  double area = 0.0;  ///< mm^2
  double back = 0.0;  ///< the tool is drawn back from it by so much, mm
};

struct Mounted {
  Setup setup;
  Vec3 fixture_deg;   ///< about the table's x, then y, then z
  double area = 0.0;  ///< of the poses that the machine reaches, mm^2
};

class Mounting {
 public:
  /// `bounds`: of the part, mm. `machine` must outlive the object; null: everything is reached as the part
  /// lies.
  Mounting(const MachineModel* machine, const Box& bounds, double tool_length);

  /// Turned by quarters, and with `axis` of the part along the table's: the first with which the machine
  /// reaches most of the poses. Asks some hundreds of the poses.
  Mounted best(std::span<const CutPose> poses, std::optional<Vec3> axis,
               std::optional<Point<Part>> on_axis) const;
  /// The ways of turning by quarters.
  const std::vector<Vec3>& quarters() const { return quarters_; }
  /// The part turned so, its middle or `on_axis` on the rotary table's axis.
  Setup setup(Vec3 fixture_deg, std::optional<Point<Part>> on_axis) const;
  /// The same with the part so high over the table that the head does not go below it at these poses.
  Setup raised(const Setup& setup, std::span<const CutPose> poses) const;
  /// What of the limits a job written for that set-up asks; nothing: no machine.
  std::optional<MachineReach> reach(const Setup& setup) const;
  const MachineModel* machine() const { return machine_; }

 private:
  const MachineModel* machine_;
  Box bounds_;
  double tool_length_;
  Angle tilt_max_;  ///< that a job for the machine asks
  std::vector<Vec3> quarters_;
};

}  // namespace tiltfeed::pathgen
