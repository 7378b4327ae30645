#pragma once
// The direction and the distances of the passes with which the machine takes the least time, and which leave
// no more than the job's own.

#include <functional>
#include <memory>
#include <optional>

#include "daemon/plan/operation_plan.h"

namespace tiltfeed::daemon {

/// Plans the job: path, joints and times; `rest`: what it leaves uncut, too. Null where that fails.
using PlanOnce = std::function<std::unique_ptr<OperationPlan>(const config::Job& job, bool rest)>;

/// What was found.
struct Shortened {
  std::unique_ptr<OperationPlan> plan;  ///< null: none is quicker than the job's own
  std::size_t tried = 0;                ///< plans besides its own
};

/// Are its rows even ones that may be laid anew, as far apart as ridges allow?
bool has_ridges(const pathgen::PlanOptions& plan);

/// Where the axis goes through a point, its frame so turned about that that rows along x' go round the
/// table's axis: the tilt stands, and the table turns. The tool axis is the same at every place. Nothing in
/// another mode, where rows go round it already, and where the job bounds the frame's angles.
std::optional<pathgen::AxisFrame> round_table(const pathgen::PlanOptions& plan);

/// So many closed rows the same way round keep the rotary within its limits, begun anywhere near the middle
/// between them: LinkingOptions::rounds. 0: it has no turns to spare.
std::uint32_t rounds_of(const MachineModel& machine);

/// `own`: the job as it is, planned with what it leaves. Tries other directions of the passes, of raster,
/// split and rough. Evenly spaced rows are planned with a quarter of them first, and only the quickest whole.
/// Evenly spaced rows of a ball may also go as far apart as ridges allow (StepMeasure::kRidge), in the best
/// direction and its own. These are no higher than what its own rows leave on most of the surface, or than
/// Pattern::optimise_scallop. Each plan is like the job's own but for that;
/// rows further apart are joined over twice the distance. Where many of the best plan's rows are closed they
/// are then joined without turning back, too. Properties: 1 What is taken leaves no more
/// between passes (or than that scallop), no more of the surface over the limit, no more uncut, and not a
/// hundredth more of walls, than `own` does (kSameRest). 2 It takes less time. 3 At most kMostTried plans are
/// tried. 4 The same job gives the same.
Shortened shorten(const OperationPlan& own, const PlanOnce& plan);

/// Two heights or areas are the same within this share.
inline constexpr double kSameRest = 1e-3;
inline constexpr std::size_t kMostTried = 16;

}  // namespace tiltfeed::daemon
