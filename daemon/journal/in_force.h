#pragma once
// What a program has put in force before one of its lines: where its axes are, its modes, spindle, coolant.
// Gathered from the program's start; the ways back into a program are made from it.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/machine_profile.h"
#include "daemon/program/numeric_block.h"

namespace tiltfeed::daemon {

/// Of a way off the part, mm: less is not worth a move.
inline constexpr double kLeastRetract = 1.0;

struct InForce {
  /// Where an axis is.
  enum class Place : std::uint8_t {
    kUnsaid,   ///< the program has not said
    kProgram,  ///< in program coordinates
    kMachine,  ///< at a place of the machine's own (G53)
  };
  static constexpr int kAxes = 5;

  double at[kAxes] = {};    ///< X Y Z tilt rotary
  Place place[kAxes] = {};  ///< what `at` means
  bool inverse_time = false, rapid = true;
  bool arc = false;  ///< G2 or G3 is in force
  int plane = 17;    ///< G17, G18 or G19
  double feed = 0.0, spindle = 0.0;
  int spindle_code = 5;
  bool mist = false, flood = false;
  std::optional<int> chosen;  ///< the newest T word, as long as no M6 has taken it

  /// The blocks of a line.
  void take(const NumericBlock& block);
  /// Modes by their words: a line may state one long before a move uses it.
  void take_words(std::string_view line);

  /// Requires: is_placed(), or that nobody looks at the other axes.
  Joints joints() const { return {at[0], at[1], at[2], at[3], at[4]}; }
  /// Every axis that the machine has is at a place of the program's.
  bool is_placed(const MachineModel& machine) const;
  /// Letters of the machine's axes whose place is `which`.
  std::string letters(const MachineModel& machine, Place which) const;
  /// Words of the linear axes of `letters`, and of the rotary ones where it has an R, whose place is `which`:
  /// " X1 Y2".
  std::string words(const config::MachineProfile& machine, Place which, std::string_view letters) const;
  /// The modes as lines of their own, one code each. `feed_before`: of the last feed move, mm/min: G1 has
  /// to have one. Requires: G94 is in force.
  std::vector<std::string> mode_lines(double feed_before) const;
};

}  // namespace tiltfeed::daemon
