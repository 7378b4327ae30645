#pragma once
// A whole program against the part, as it is read: memory does not grow with its length.

#include <functional>
#include <istream>
#include <string>

#include "sim/collision/collision_check.h"
#include "sim/control/control_reader.h"
#include "sim/proof/proof.h"

namespace tiltfeed::sim {

struct ProgramProof {
  Proof proof;
  std::uint64_t blocks = 0;  ///< that state where all axes are
  Collisions collisions;
  bool inside = false;  ///< the tip is in the part where the program takes over; at `deepest`
};

/// `check`: null: no collisions are looked for. `share`: of the program that is done, 0..1. Errors: kInput:
/// the program is not understood, or does not move; kIo; kCancelled.
Result<ProgramProof> prove_program(std::istream& in, const std::string& name, const config::Job& job,
                                   const Prover& prover, const CollisionCheck* check, int threads,
                                   const std::function<bool(double share)>& progress);

/// The moves from `first` to `last`, blocks counted from 1, as a path. Errors: likewise.
Result<ToolPath> moves_between(std::istream& in, const std::string& name, const config::Job& job,
                               std::uint64_t first, std::uint64_t last);

}  // namespace tiltfeed::sim
