#pragma once
// The proof of a program, judged in turn: what it says of the printed text of a case and of damaged moves,
// against depths of the tool at poses along them.

#include <string>
#include <vector>

#include "config/job.h"
#include "kinematics/joints/joint_path.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::attack {
using namespace pathgen;
using namespace config;

struct ProofVerdict {
  std::size_t moves = 0, damaged = 0, refused = 0;  ///< held; damaged moves held, and of those refused
  std::vector<std::string> findings;                ///< gouges that it proves, and where it is wrong
  /// The program is rightly refused for the control's own retract or approach, as a tool that points upwards
  /// from below has the part above it, or for its own approach, as the first pose is shut in.
  std::string refusal;
};

/// `deepest`: of the program in the part, as found at poses. Bounds: the depth of a gouge that it tells is
/// that at the pose that it tells, and no pose is deeper than it says, each to within 5 % of the tolerance.
ProofVerdict judge_proof(const Job& job, const CheckedMesh& part, const JointPath& joints, double deepest);

}  // namespace tiltfeed::attack
