#pragma once
// What a controller of the Grbl family says, one line at a time. Strict: a damaged line is kGarbled, never an
// ok.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tiltfeed::daemon {

enum class GrblReplyKind {
  kOk,        ///< exactly "ok"
  kError,     ///< "error:N", or anything else that starts so
  kAlarm,     ///< "ALARM:N", or anything else that starts so
  kBanner,    ///< "Grbl 1.1h ...", "GrblHAL ...": the controller has just started
  kStatus,    ///< "<Idle|MPos:...>"
  kFeedback,  ///< "[...]", "$N=...", ">...": information
  kGarbled,   ///< anything else, and a status report that does not end
};

GrblReplyKind classify_reply(std::string_view line);

/// A status report, as far as it is used here.
struct GrblStatus {
  std::string state;           ///< Idle, Run, Hold:0, ...
  int planner_free = -1;       ///< first figure of Bf:, -1 when absent
  int receive_free = -1;       ///< second figure of Bf:
  std::string position;        ///< MPos: or WPos: and Ln:, as text: compared only, to see progress
  std::vector<double> axes;    ///< the figures of MPos: or WPos:; none when they are damaged
  bool in_work = false;        ///< they are WPos:
  std::vector<double> offset;  ///< WCO:, of most reports absent
  int decimals = 0;            ///< of `axes`
  int line = -1;               ///< Ln:, -1 when absent
  int feed_override = -1, rapid_override = -1, spindle_override = -1;  ///< Ov:, percent, -1 when absent
  double feed = -1.0, spindle = -1.0;      ///< FS:, mm/min and 1/min, -1 when absent
  std::string inputs = {}, switched = {};  ///< letters of Pn: (inputs that are on) and A: (spindle, coolant)
};

/// Requires: classify_reply(line) is kStatus. Nothing when the state is not a word of letters.
std::optional<GrblStatus> parse_status(std::string_view line);

/// "XYZAC" of "[AXS:5:XYZAC]"; empty when `line` is not one.
std::string parse_axis_letters(std::string_view line);

/// The axes stand in this state of a report, whatever the buffers hold: a reset keeps the position.
bool is_standing(std::string_view state);

/// The figures of "[OPT:flags,planner,receive,...]"; nothing when `line` is not one.
struct GrblBuffers {
  int planner = 0;
  int receive = 0;
};
std::optional<GrblBuffers> parse_buffers(std::string_view line);

}  // namespace tiltfeed::daemon
