#pragma once
// What a program has put in force on a control of the machine shop before a line: spindle, coolant, modes of
// feed and motion, high-speed function, clamps, work offset, and what its comments say of the tool.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/program_format.h"
#include "daemon/post/dialect_words.h"

namespace tiltfeed::daemon {

/// Of programs in words and numbers (rs274, fanuc, haas).
class ControlState {
 public:
  explicit ControlState(const config::ProgramFormat& format) : format_(&format) {}

  /// The next line as it stands in the file. Lines that are no words change nothing.
  void take(std::string_view raw);

  double speed = 0.0;                ///< S, 1/min
  int turn = 0;                      ///< 3 or 4; 0: the spindle stands
  std::vector<double> coolants;      ///< as PathEvent::value, in their order
  bool inverse = false;              ///< G93
  std::string feed;                  ///< F as printed; empty: none is in force
  int motion = -1;                   ///< 0 to 3; -1: none is
  int plane = 17;                    ///< of arcs
  bool compensated = false;          ///< G41 or G42
  bool incremental = false;          ///< G91
  std::string smoothing, corner;     ///< lines of the high-speed function and of G61 or G64 P; empty: none
  std::string offset;                ///< words of the work offset
  std::vector<std::string> clamps;   ///< of axes that are clamped
  std::vector<std::string> of_tool;  ///< TILTFEED comments: operation, tool length, part zero, fixture
  bool away =
      false;  ///< the tool is off at the machine's own place, or changed, and no block has moved since
  int linear_decimals = 0, rotary_decimals = 0;  ///< the most that axis words have had

  /// Lines that put in force what `way` has not, where that is the end of a way in: clamps, modes of feed and
  /// motion. Tool, length, plane, offset, spindle and coolant are the way's own.
  std::vector<std::string> lines_behind(const ControlState& way) const;
  /// A block of the path has moved.
  void moved() { away = false; }

 private:
  void take_comment(const std::string& text);
  void take_words(const DialectWords& words, const std::string& line);
  bool take_own(const std::string& line);

  const config::ProgramFormat* format_;
  std::optional<std::string> clamp_tilt_, clamp_rotary_;
};

}  // namespace tiltfeed::daemon
