#include "daemon/post/text_drawing.h"

#include <array>
#include <ostream>

namespace tiltfeed::daemon {

void write_text_drawing(const AptProgram& program, std::ostream& out) {
  for (const AptOperation& op : program.operations)
    for (std::size_t i = 0; i < op.path.moves.size(); ++i) {
      const auto& [pose, kind, facet] = op.path.moves[i];
      const std::array<float, kTextNumbers> record{
          static_cast<float>(pose.tip.x),  static_cast<float>(pose.tip.y),  static_cast<float>(pose.tip.z),
          static_cast<float>(pose.axis.x), static_cast<float>(pose.axis.y), static_cast<float>(pose.axis.z),
          static_cast<float>(kind),        static_cast<float>(op.lines[i])};
      out.write(reinterpret_cast<const char*>(record.data()), sizeof record);
    }
}

}  // namespace tiltfeed::daemon
