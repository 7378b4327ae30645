#pragma once
// The words of motion blocks: axis words and F, as a dialect prints them.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "daemon/post/dialect.h"
#include "daemon/post/printed_arc.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// F of a block.
struct FeedWord {
  double value = 0.0;
  bool clamped = false;  ///< to the control's range
};

/// Where a block comes from and what it shall do.
struct BlockStep {
  Joints from, to;
  double seconds = 0.0;
  double tip_feed = 0.0;  ///< mm/min, under TCP and in a plane
  double arc = 0.0;       ///< the length of its arc, mm; 0: it is straight
};

class PrintedWords {
 public:
  PrintedWords(const config::ProgramFormat& format, const MachineModel& machine);

  /// Appends " X1.5 ..." for the words that differ from `from`, or all.
  char* axes(char* out, const Joints& from, const Joints& to, bool all) const;
  // The words of an operation's way to its first block, apart: " A1 C2", " X3 Y4", " Z5".
  char* rotaries(char* out, const Joints& to) const;
  char* place(char* out, const Joints& to) const;
  char* height(char* out, const Joints& to) const;
  /// Appends the words of an arc that ends at `to`: both of its plane's axes, and its centre where that
  /// stands in the block.
  char* arc(char* out, const Joints& to, const PrintedArc& arc) const;
  /// Appends the centre, absolute: "X1 Y2" or "I1 J2". Requires: DialectTable::pole_letters.
  char* pole(char* out, const Joints& from, const PrintedArc& arc) const;
  FeedWord feed_of(const BlockStep& step) const;
  /// Appends " F100".
  char* feed(char* out, double value) const;
  /// F stands on every feed block.
  bool feed_always() const { return inverse_; }

 private:
  char* axis(char* out, char letter, double value, int decimals) const;
  char* slide(char* out, char letter, double place) const;
  char* value(char* out, double value, int decimals) const;
  char* turn(char* out, const RotaryAxis& axis, double from, double to) const;
  char* number(char* out, double value, int decimals) const;
  double way(const Joints& from, const Joints& to) const;

  const config::ProgramFormat& format_;
  const DialectTable& table_;
  const RotaryAxis &tilt_, &rotary_;
  bool inverse_;
  double unit_;  ///< of the linear words, mm
};

}  // namespace tiltfeed::daemon
