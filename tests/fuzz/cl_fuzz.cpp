// CL text: what is read is written and read again as the same path.

#include <cmath>
#include <sstream>

#include "kinematics/cl_text/cl_file.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;

FUZZ_TARGET(cl) {
  std::istringstream in{std::string(bytes)};
  const auto path = read_cl(in, "fuzz.cls");
  if (!path) return HOLDS(path.error().message.find("fuzz.cls") != std::string::npos);
  for (const Move& move : path->moves) HOLDS(std::abs(length(move.pose.axis) - 1.0) < 1e-9);
  // A foreign file may state no feed; what is written always does.
  if (path->cut_feed.mm_per_min() <= 0.0 || path->plunge_feed.mm_per_min() <= 0.0) return;
  std::ostringstream out;
  write_cl(*path, out);
  std::istringstream back(out.str());
  const auto again = read_cl(back, "again.cls");
  HOLDS(again && again->moves.size() == path->moves.size());
}
