#pragma once
// What a planned and posted job does to its part, by brute force: the moves as the machine makes them,
// against the facets of the file, by the exact distances and tool solids of sim/.

#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/joints/joint_path.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/plan/plan.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;

struct Verdict {
  double gouge = 0.0;                         ///< deepest on cuts and plunges, mm
  double rapid = 0.0;                         ///< deepest on rapids, mm
  double in_part = 0.0;                       ///< deepest on any move in the part as repaired, mm
  double contact = 0.0;                       ///< largest gap where contact is meant, mm
  double left = 0.0;                          ///< most left over what the neighbouring passes must leave, mm
  std::size_t poses = 0, surface_points = 0;  ///< looked at; of the surface: that the tool reaches
  std::size_t stock_places = 0;               ///< of the blank that rapids pass, where the job states one
  std::vector<std::string> findings;          ///< what is over the tolerance: "KIND DEPTH mm at PLACE"
};

/// `part`: as repaired, which contact and cover are held against; gouges are held against `stl` too.
Verdict judge(const Job& job, const Stl& stl, const CheckedMesh& part, const Plan& planned,
              const JointPath& joints);

}  // namespace tiltfeed::attack
