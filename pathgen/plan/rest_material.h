#pragma once
// What of the part the tool cannot or may not cut in one axis field, facet by facet. (U1) in
// pathgen/plan/README.md.

#include <functional>
#include <optional>
#include <vector>

#include "pathgen/envelope/envelope.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/options/plan_report.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/cl_field.h"

namespace tiltfeed::pathgen {

/// Is a tool that could stand there kept off, by what stands beyond the axis feature?
using KeptOff = std::function<bool(const EnvelopePoint& stand)>;
/// What holds the tool off a stand on the mode's axis, where it may lean: the part, or body `body` of the
/// fixtures.
struct HeldStand {
  RestReason why = RestReason::kHolder;
  std::uint32_t body = 0;
};
/// Empty: the envelope knows all that holds the tool. Called from several threads.
using HeldUpright = std::function<std::optional<HeldStand>(const EnvelopePoint& stand)>;

/// Holds the tool, at the place of the envelope over its contact with each piece of each facet, against that
/// piece: it is uncut when it stays further off than `options.tolerance`, or when that place is left out.
/// What lies between two passes counts as cut; what they leave there is said apart, of `path`, but for what
/// the tool is kept off: that is uncut by the shank. In a hollow as wide as the tool a place may be called
/// uncut that another place of the envelope would touch by chance. A place where `held` holds the tool on the
/// mode's axis is uncut where the path leaves more than the limit. The same for any number of threads. When
/// the user stops it through `report`, what it returns is worth nothing.
RestReport find_rest_material(const ClField& field, const PlanOptions& options,
                              const EnvelopeOptions& envelope, const std::vector<Move>& path,
                              const ReportShare& report = {}, const KeptOff& kept_off = {},
                              const HeldUpright& held = {});

/// Of each facet of the mesh the share that faces the tool; 0: RestReport counts it as turned away. Over the
/// same pieces as RestFacet's share. Requires: an axis field.
std::vector<double> facing_shares(const Mesh& mesh, const PlanOptions& options);

}  // namespace tiltfeed::pathgen
