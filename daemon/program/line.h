#pragma once
// A line of a program as it goes onto a wire.

#include <cstdint>
#include <string>

namespace tiltfeed::daemon {

/// Longest line of any controller that is known (grblHAL 256), bytes without line end.
inline constexpr std::size_t kMaxLine = 256;
/// Longest line of the file itself, comments included: the reading window.
inline constexpr std::size_t kMaxRawLine = 65536;

/// One line (its end in the file: LF, CR LF, or CR alone) as it is sent: upper case, printable ASCII, no
/// blanks, no comments, never empty.
struct Line {
  std::uint64_t number = 0;  ///< 1-based in the file
  std::string text;
  bool alone = false;  ///< nothing else may be on its way with it: M0 M1 M6, G10 G28.1 G30.1
  bool waits = false;  ///< of these, M0 M1 M6: answered when the operator has acted
  double dwell = 0.0;  ///< seconds that G4 asks for
};

}  // namespace tiltfeed::daemon
