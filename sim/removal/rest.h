#pragma once
// What a program leaves of the surface that the job's tool reaches: whether it is complete. (W9) in
// sim/removal/README.md.

#include <vector>

#include "config/job.h"
#include "sim/removal/executed_path.h"
#include "sim/removal/probes.h"
#include "sim/solid/tool_solid.h"

namespace tiltfeed::sim {

/// Where the tool may stand when its end touches the part: in the job's axis field, containment and tilt
/// limit, clear of the part. Its own maths, not the planner's.
class Reach {
 public:
  /// Both must outlive it. `directions`: the only ones that count, unit, where the axis is free or indexed;
  /// empty: any.
  Reach(const config::Job& job, const PartDistance& surface, std::vector<Vec3> directions = {});

  /// Can the tool's end leave `place` of a facet with that unit normal as the job asks? False on walls, too:
  /// what leans less than kSteepest from the tool axis.
  bool touches(Point<Part> place, Vec3 normal) const;

 private:
  bool clear(const Pose& pose) const;
  bool comes_off(const Pose& pose) const;
  bool contained(Point<Part> reference) const;
  std::optional<Vec3> field_axis(Point<Part> reference) const;
  Pose touching(Point<Part> place, Vec3 normal, Vec3 axis) const;
  Point<Part> reference_of(const Pose& pose) const;

  const config::Job& job_;
  const PartDistance& surface_;
  ToolSolid solid_;
  std::vector<Vec3> directions_;  ///< that are tried where the axis is free or indexed
  double least_facing_;           ///< cosine of the furthest that these lean from the normal
};

/// Material that the tool reaches and the program leaves.
struct Rest {
  double limit = 0.0;         ///< what may be left, mm
  double area = 0.0;          ///< of the part's surface where more is left, mm^2
  double out_of_reach = 0.0;  ///< of the surface that is over the limit too but the tool does not reach, mm^2
  /// Of that: within reach of other directions than those of an indexed job's program, mm^2.
  double elsewhere = 0.0;
  /// Of the area: where the passes lie so far apart on the part that they leave as much, mm^2; and the
  /// furthest that they lie apart there, mm.
  double between_passes = 0.0, apart = 0.0;
  double left = 0.0;               ///< most of it, mm; what is never cut counts as Probes::reach()
  bool never_cut = false;          ///< there
  std::uint32_t facet = kNoFacet;  ///< of the STL file, there
  Point<Part> place;
};

/// Over the probes' values after a run of `path`. Of an indexed job what the program's own directions reach
/// counts. The same for any number of threads.
Rest find_rest(const config::Job& job, const ExecutedPath& path, const Probes& probes, double limit,
               int threads);

}  // namespace tiltfeed::sim
