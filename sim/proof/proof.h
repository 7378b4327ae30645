#pragma once
// Every move of a program against the part: exact distances of the whole tool along the whole of each move,
// by bounds from below that are made finer where they do not tell. Formulas (P1)..(P4) are in
// sim/proof/README.md.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "config/job.h"
#include "pathgen/mesh/mesh.h"
#include "sim/control/move_frames.h"
#include "sim/proof/tool_core.h"

namespace tiltfeed::sim {

/// What is proven is proven to within this share of the tolerance.
inline constexpr double kProofError = 0.01;

/// The tool in the part, deeper than the tolerance.
struct ProvenGouge {
  ToolPart tool = ToolPart::kCutter;
  double depth = 0.0;  ///< mm
  bool rapid = false;
  std::uint32_t line = 0;   ///< of the text, from 1
  std::uint64_t block = 0;  ///< of those that move an axis, from 1
  Pose pose;                ///< of the tool
  std::uint32_t facet = 0;  ///< of the STL file
};

/// Of some moves.
struct Proof {
  std::uint64_t moves = 0;
  double gouge = 0.0;                  ///< the tool comes nowhere deeper into the part, mm
  std::optional<ProvenGouge> deepest;  ///< over the tolerance

  /// Adds what comes after.
  void add(const Proof& next);
};

class Prover {
 public:
  /// Outlived by `part` and `job`.
  Prover(const pathgen::CheckedMesh& part, const config::Job& job);

  /// The part with the stock that the job leaves on it, less the tolerance, is clear of cutter, shank and
  /// holder along the moves; each begins where the one before ends, or elsewhere. The same moves give the
  /// same proof. What cuts no deeper than `known` (mm) is not looked for, and the gouge is said to be as
  /// deep. Thread-safe.
  /// Properties: 1 The tool comes nowhere deeper into the part than Proof::gouge. 2 A gouge that is deeper
  /// than the tolerance by kProofError of it is told, and one within the tolerance is not. 3 `deepest` has
  /// its move, and a pose at which the tool is so deep: within kProofError. 4 Where none is told,
  /// Proof::gouge is at most half the tolerance above the true depth.
  Proof hold(std::span<const ProgramMove> moves, double known = 0.0) const;
  /// The tool's tip is in the part there: what `hold` does not see as long as no surface is touched.
  bool inside(const Pose& pose) const;
  /// How far the tip is from the part's surface, mm.
  double depth_inside(const Pose& pose) const { return surface_.nearest(pose.tip).value; }
  const MoveFrames& frames() const { return frames_; }

 private:
  class Run;
  const pathgen::CheckedMesh& part_;
  double tolerance_;
  PartDistance surface_;
  ToolSolid solid_;
  std::vector<ToolCore> cores_;
  MoveFrames frames_;
};

}  // namespace tiltfeed::sim
