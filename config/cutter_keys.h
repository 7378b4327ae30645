#pragma once
// The form of a cutter, in a job or in a tool library.

#include "config/section.h"
#include "pathgen/options/cutter.h"

namespace tiltfeed::config {

/// The keys of a cutter's form, in a section that knows them. Rules across keys are checked where all of
/// these are there.
pathgen::Cutter read_cutter_form(const Section& section);
/// The smallest radius of the cutter's outline, mm: of the rounded edge, or of the whole where the edge is
/// sharp.
double smallest_radius(const pathgen::Cutter& cutter);

}  // namespace tiltfeed::config
