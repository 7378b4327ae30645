#pragma once
// A line of a program for a control of the machine shop (Fanuc, Haas), as DNC counts lines, and where it is.

#include <cstdint>
#include <optional>
#include <string>

#include "config/machine_profile.h"
#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// Whether programs of this profile, which go out over DNC, are in the words of such a control.
bool in_control_words(const config::MachineProfile& machine);

/// Where a block of DNC stands in the file.
struct ControlLine {
  std::uint64_t line = 0;   ///< of the file; 0: the program has fewer blocks
  std::string text;         ///< as sent
  std::uint64_t count = 0;  ///< blocks of the program
  std::uint64_t next = 0;   ///< the first block in a line behind `behind`; 0: there is none
};
/// Errors: those of LineReader.
Result<ControlLine> find_control_line(const std::string& path, std::uint64_t number,
                                      std::uint64_t behind = 0);

/// A block with the words that are in force at its end.
struct ControlPlace {
  std::uint64_t line = 0;
  std::string text;
  std::optional<Joints> words;      ///< none: not every axis has a place yet. Under TCP X Y Z are the tip's
  bool tcp = false, plane = false;  ///< the words are under TCP, in a tilted plane
  bool is_move = false;
  std::uint64_t moves = 0;  ///< of the path up to and with this one, counted from 1: entry of the block map
};
/// Errors: kUsage: the program has fewer blocks; kInput: a line that is not understood; those of LineReader.
Result<ControlPlace> find_control_block(const std::string& path, const config::MachineProfile& machine,
                                        std::uint64_t number);

}  // namespace tiltfeed::daemon
