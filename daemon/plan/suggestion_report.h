#pragma once
// Proposals for a part, as a table for a machinist and as JSON.

#include <string>

#include "config/machine_profile.h"
#include "config/new_job.h"
#include "pathgen/suggest/suggest.h"

namespace tiltfeed::daemon {

/// What was asked, and what came of it.
struct SuggestionOutcome {
  std::string stl;
  double stl_unit_mm = 1.0;
  const pathgen::CheckedMesh& part;
  const config::NamedCutter& cutter;
  const config::MachineProfile* machine;  ///< null: none was named
  const pathgen::Suggestions& found;
  double seconds = 0.0;
};

/// A line a proposal, the best first, with the worst reasons for what it does not reach.
std::string suggestion_text(const SuggestionOutcome& outcome);
std::string suggestion_json(const SuggestionOutcome& outcome);

/// The job for proposal `index`; files relative to the folder of `path`, the job's own name. Requires: a
/// machine.
config::NewJob job_of(const SuggestionOutcome& outcome, std::size_t index, const std::string& path);

}  // namespace tiltfeed::daemon
