#pragma once
// CYCLE/ of an APT file: what the tool does at each point that follows, as straight moves along its axis.

#include <optional>
#include <string>
#include <vector>

#include "kinematics/cl_text/apt_record.h"

namespace tiltfeed {

enum class CycleKind { kDrill, kDeep, kBreakChip, kTap, kBore };

/// Lengths in the file's unit; heights over the point, along the tool axis.
struct AptCycle {
  CycleKind kind = CycleKind::kDrill;
  std::optional<double> depth;     ///< below the point, > 0
  std::optional<double> rapid_to;  ///< from here on the tool feeds
  std::optional<double> retract;   ///< where it goes in the end
  bool to_start = false;           ///< that is where it stood before the cycle
  std::vector<double> steps;       ///< of deep and chip-breaking ones; the last goes on
  double dwell = 0.0;              ///< at the bottom
  bool dwell_turns = false;        ///< in turns of the spindle; else seconds
  std::string feed_unit;           ///< MMPM, IPM, MMPR, IPR, PERMIN, PERREV; "": the FEDRAT/ in force
  double feed = 0.0;
};

/// What happens at the end of a step.
enum class CycleThen { kNothing, kDwell, kReverse, kForward };

struct CycleStep {
  double height = 0.0;  ///< over the point, file's unit
  bool rapid = false;
  CycleThen then = CycleThen::kNothing;
};

/// CYCLE/ of a kind, with `WORD,number` pairs or with depth, feed and clearance by position; CYCLE/ON changes
/// what it states. Errors: words that are not understood, a number whose meaning is not clear, no depth, no
/// clearance, no step where one is wanted.
AptVerdict read_cycle(const AptRecord& record, AptCycle& cycle);

/// From `rapid_to` above the point to its end; `retract` is that of this point. Requires: read_cycle was
/// content; `unit_mm` to tell small distances.
std::vector<CycleStep> steps_of(const AptCycle& cycle, double retract, double unit_mm);

}  // namespace tiltfeed
