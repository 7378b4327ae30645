#pragma once
// What in the job keeps the tool from the part: told when a plan with one axis field fails.

#include <string>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// The cause, its figures and the keys to change; empty where no test below holds. With one axis field and a
/// closed part only. In this order, 1 and 2 asked at even places of point, line or circle along the part:
/// 1 inside work, and half of the places or more lie in the material;
/// 2 inside work, and at every other place the part is nearer than the cutter's radius with its stock;
/// 3 within the tilt limit less than a tenth of the area faces this sense of what faces the other one;
/// 4 at none of many places that face the tool within the containment does the cutter's ball fit, whose
///   room is told;
/// 5 outward work, and a quarter or more of the line or circle lies in the material and as much outside.
/// Looks at every facet for every place.
std::string likely_cause(const CheckedMesh& part, const PlanOptions& options);
/// The error of a plan, led by its likely cause if there is one. kUnreachable, kLimit and kGouge only.
Error with_cause(Error error, const CheckedMesh& part, const PlanOptions& options);

}  // namespace tiltfeed::pathgen
