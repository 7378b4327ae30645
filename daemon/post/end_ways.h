#pragma once
// The first and the last way of a planned path: between where the machine's Z brings the tool and the part
// the tool goes along its axis.

#include "config/job.h"
#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

/// Where the head leans, puts a rapid along the tool axis before the first pose and one behind the last. They
/// lead to where the whole tool, grown by its stock and its guards' clearances, is beyond a plane that is the
/// job's clearance off the part, so that it can go up and down along the machine's Z with the rotaries as
/// they stand: over the part, or beside it, whichever is nearer. Where the travels end before that or the way
/// is blocked, beyond the plane square to the tool axis. Where all three are blocked, the first that is free
/// without the guards' clearances, or else nothing is put in. Where the tool comes nearer to the part than
/// half of the approach on such a way, it is a plunge. `part`: with fixtures and blank, where the job has
/// any, in this order behind it. Returns what was put in, mm.
double add_end_ways(ToolPath& path, const pathgen::Mesh& part, const config::Job& job);

}  // namespace tiltfeed::daemon
