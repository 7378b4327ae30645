#pragma once
// Warnings for points that the passes skip or leave uncut.

#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/options/plan_report.h"
#include "pathgen/pattern/holder_clearance.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

/// Why something is left out, in the words of a message.
struct Reason {
  RestReason why;
  const char* text;
};

/// Where faces are chosen and no pass comes near to them.
inline constexpr const char* kNoFaceReached =
    "the passes come to none of the faces of containment.faces: they face away from the tool, lie out of the "
    "containment, or something stands in front of them; check axis.mode, axis.n and the faces";

/// Adds a warning for each reason: how many points, which facets, what to change.
/// Errors: kLimit or kUnreachable when nothing is left. Notes in the report what each fixture keeps the tool
/// from.
Result<void> report_refusals(const ClSurface& surface, const Passes& passes, const PlanOptions& options,
                             PlanReport& report);
/// Adds a warning for each fixture that keeps the tool from something: how much, where, and from what of it.
/// `of_what` are the points.
void warn_fixtures(const char* of_what, PlanReport& report);
/// Where the tool touches `place` of the part with the normal and no direction is clear of fixtures: the one
/// in the way along the normal, else the nearest; its entry in the report, made if there is none.
KeptByFixture& note_fixture(const PlanOptions& options, const SweptTool& tool, Point<Part> place, Vec3 normal,
                            PlanReport& report);
/// Adds a warning of patches left out as they touch the axis point, line or circle; none if there are none.
void warn_too_near(const ClSurface& surface, const std::vector<PatchId>& too_near, PlanReport& report);
/// Adds a warning of what stays where the upper edge of a taper touches, if that is over the tolerance.
void warn_taper_edge(const PlanOptions& options, PlanReport& report);
/// Adds a warning of what rounding off left in corners, if anything.
void warn_smoothed(const Smoothed& smoothed, PlanReport& report);
/// Adds a warning of what passes leave between them over what was asked, if anything.
/// `remedy`: what leaves less between two passes.
void warn_between(const BetweenPasses& between, const char* remedy, PlanReport& report);
/// Adds a warning of where shank or holder come near and guards only report, if anywhere.
void warn_touches(const Touches& touches, PlanReport& report);

}  // namespace tiltfeed::pathgen
