#include "daemon/session.h"

namespace tiltfeed {

const char* phase_name(Phase phase) {
  switch (phase) {
    case Phase::kOpening:
      return "opening";
    case Phase::kStreaming:
      return "streaming";
    case Phase::kDraining:
      return "draining";
    case Phase::kDone:
      return "done";
    case Phase::kFault:
      return "fault";
  }
  return "";
}

std::string quote_line(std::uint64_t number, const std::string& text) {
  return "line " + std::to_string(number) + " '" + text + "'";
}

}  // namespace tiltfeed
