// CL text of any CAM system: what is read is written and read again as the same operations.

#include <cmath>
#include <sstream>

#include "kinematics/cl_text/apt_file.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;

FUZZ_TARGET(apt) {
  std::istringstream in{std::string(bytes)};
  const auto program = read_apt(in, "fuzz.apt", {});
  if (!program) return HOLDS(program.error().message.find("fuzz.apt") != std::string::npos);
  HOLDS(!program->operations.empty());
  for (const AptOperation& operation : program->operations) {
    HOLDS(!operation.path.moves.empty() && operation.lines.size() == operation.path.moves.size());
    for (const Move& move : operation.path.moves) {
      HOLDS(std::isfinite(move.pose.tip.x) && std::isfinite(move.pose.tip.y) &&
            std::isfinite(move.pose.tip.z));
      HOLDS(std::abs(length(move.pose.axis) - 1.0) < 1e-9);
    }
  }
}
