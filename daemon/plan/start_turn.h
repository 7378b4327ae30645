#pragma once
// The turn of the table from home to its place, with which a program under TCP may begin (tcp_start).

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "config/job.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::daemon {

struct StartTurn {
  /// How high the tip is over the highest point of what stands on the table, where it is the lowest; mm.
  double height = 0.0;
  std::size_t blocks = 0;
};

/// Before the first block of a path that stands at `first`; nothing: the table does not turn there. `held`:
/// what stands on the table.
std::optional<StartTurn> start_turn(const pathgen::Mesh& held, const config::Job& job, const Joints& first);

/// A line of the report, a warning where the height is less than the job's clearance.
std::string start_turn_text(const StartTurn& turn, const config::Job& job);

/// The same for the program's header.
std::string start_turn_comment(const StartTurn& turn, const config::Job& job);

/// What to change where the proof names a line in which the table turns; empty: another line. `head`: the
/// program's first lines, these among them; `name`: the program's, as in the message.
std::string start_turn_advice(const StartTurn& turn, const config::Job& job, std::string_view head,
                              const std::string& message, const std::string& name);

}  // namespace tiltfeed::daemon
