#pragma once
// Why more is left than the job asks for: how far apart the passes lie on the part. (W10) in
// sim/removal/README.md.

#include <cstdint>
#include <vector>

#include "config/job.h"
#include "kinematics/basics/geometry.h"
#include "sim/removal/executed_path.h"

namespace tiltfeed::sim {

/// The cutting moves of a path, to ask how far apart they pass a place.
class PassDistances {
 public:
  PassDistances(const config::Job& job, const ExecutedPath& path);

  /// Distance, mm, of the two places at which the tool passes `touching`, its CL reference where it would
  /// touch, nearest on either side; across the feed of `move`. 0 where there is no pass on one side within
  /// `farthest`, mm.
  double apart(Point<Part> touching, std::uint32_t move, double farthest) const;

 private:
  std::vector<Pose> references_;  ///< by move; the first: where the path starts
  std::vector<bool> cuts_;        ///< does the move to it cut?
};

/// What passes so far apart leave between them on a plane, by the rounding of the cutter, mm; at most its
/// radius.
double left_between(const pathgen::Cutter& cutter, double apart);

}  // namespace tiltfeed::sim
