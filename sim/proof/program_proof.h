#pragma once
// A whole program against the part, as it is read: memory does not grow with its length.

#include <functional>
#include <istream>
#include <span>
#include <string>
#include <vector>

#include "sim/collision/collision_check.h"
#include "sim/control/control_reader.h"
#include "sim/proof/proof.h"

namespace tiltfeed::sim {

struct ProgramProof {
  Proof proof;
  std::uint64_t blocks = 0;  ///< that state where all axes are
  Collisions collisions;
  bool inside = false;  ///< the tip is in the part where the program takes over; at `deepest`
  std::size_t gouging = 0, colliding = 0;  ///< operations of `deepest` and of `collisions`, counted from 0

  /// Adds what was found in the operation; of operations behind the first that collides nothing is kept.
  void add(Collisions found, std::size_t operation);
};

/// What an operation's moves are held against.
struct OperationProof {
  const Prover* prover;
  const CollisionCheck* check;  ///< null: no collisions are looked for
};

/// `operations`: those of one job that the program has, in their order; `held`: by operation. `share`: of the
/// program that is done, 0..1. Errors: kInput: the program is not understood, does not move, or has other
/// operations; kIo; kCancelled.
Result<ProgramProof> prove_program(std::istream& in, const std::string& name,
                                   std::span<const config::Job> operations,
                                   const std::vector<OperationProof>& held, int threads,
                                   const std::function<bool(double share)>& progress);

/// The moves from `first` to `last`, blocks counted from 1, as a path. Errors: likewise.
Result<ToolPath> moves_between(std::istream& in, const std::string& name,
                               std::span<const config::Job> operations, std::uint64_t first,
                               std::uint64_t last);

}  // namespace tiltfeed::sim
