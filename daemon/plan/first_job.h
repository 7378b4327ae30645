#pragma once
// The first job of a part: a tool of the library, a proposal for the axis, and what only a person can answer.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "config/tool_library.h"
#include "daemon/plan/suggestion_report.h"
#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed::daemon {

struct FirstJobOrder {
  std::string stl;
  double stl_unit_mm = 1.0;
  const pathgen::CheckedMesh& part;
  const config::MachineProfile& machine;
  std::optional<config::ToolLibrary> library;  ///< nothing: a ball by rule
  std::string material;                        ///< of the library's cutting data; empty: not known
  std::string job;                             ///< file that the text is for
};

/// Share of the surface that the most of the tools tried reaches: a larger tool that reaches so much of it is
/// taken.
inline constexpr double kReachesAsMuch = 0.9;

/// A commented job. Of the library's balls and taper balls three are tried, those nearest to the size that
/// goes about forty times into the part; the largest that reaches kReachesAsMuch of the most is taken.
/// Property: the text is read as a job. Errors: kInput: no tool of the library will do; those of
/// pathgen::suggest.
Result<std::string> first_job(const FirstJobOrder& order, const pathgen::Progress& progress);

}  // namespace tiltfeed::daemon
