#pragma once
// The simulated machine's own G-code reader: RS274 words to blocks, modal state resolved. Shares nothing
// with the post that wrote the program. The words that it takes are listed in sim/gcode/README.md.

#include <cstdint>
#include <functional>
#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"
#include "sim/gcode/fault.h"

namespace tiltfeed::sim {

enum class Op : std::uint8_t { kRapid = 1, kFeed = 2, kDwell = 3, kMCode = 4 };

inline constexpr int kToolNotSaid = -1;
inline constexpr double kMostTool = 1e9;  ///< larger tool numbers count as this one

/// One block with every modal value filled in.
struct Block {
  Op op = Op::kRapid;
  Joints target;      ///< absolute axis words at the block's end (mm, degrees)
  double feed = 0.0;  ///< F: 1/min when inverse_time, else mm/min; seconds for a dwell; 0 otherwise
  bool inverse_time = false;
  bool exact_stop = false;  ///< G61, G61.1: the axes stand still at its end
  int m_code = -1;          ///< for kMCode
  double spindle = 0.0;     ///< S in force, 1/min
  std::uint32_t line = 0;   ///< N word, or the 1-based count of lines read
  /// Of a motion block: the program has said where X, Y and Z are at its end. Before that, it comes from
  /// wherever the machine stood.
  bool placed = true;
  /// Of a motion block: on the way from the place that a move in machine coordinates (G53) left to the next Z
  /// in the part's, that move and this one included.
  bool off_path = false;
  bool goes_on = false;  ///< a piece of a block of the text, more of which follows
  int tool =
      kToolNotSaid;  ///< in the spindle: the T word in force at the last M6; before any, the last T word
};

/// Blocks after which a controller waits until the axes stand still: dwells and M codes.
inline bool synchronises(const Block& block) { return block.op == Op::kDwell || block.op == Op::kMCode; }

enum class MotionMode : std::uint8_t { kNone, kRapid, kFeed, kClockwise, kCounterClockwise };
inline bool is_arc(MotionMode mode) {
  return mode == MotionMode::kClockwise || mode == MotionMode::kCounterClockwise;
}
inline bool is_feed(MotionMode mode) { return mode == MotionMode::kFeed || is_arc(mode); }

/// What stays in force from line to line.
struct ModalState {
  Joints at;          ///< where the last motion block ends
  double feed = 0.0;  ///< F of G94, mm/min; 0: not set
  double spindle = 0.0;
  bool inverse_time = false;
  bool exact_stop = false;  ///< G61 or G61.1, not G64
  bool relative = false;    ///< G91
  MotionMode motion = MotionMode::kNone;
  int plane = 17;               ///< of arcs: G17, G18 or G19
  unsigned placed = 0;          ///< bits 0 to 2: X, Y, Z were stated
  bool off_path = false;        ///< G53, and no Z since
  int selected = kToolNotSaid;  ///< the last T word
  int tool = kToolNotSaid;      ///< Block::tool
  bool tool_changed = false;    ///< there was an M6
};

/// Reads one line at a time; keeps the modal state. A refused line changes nothing.
class GcodeReader {
 public:
  /// Letters of the rotary words ('A', 'C' usually), which count their turns.
  GcodeReader(char tilt_letter, char rotary_letter) : tilt_(tilt_letter), rotary_(rotary_letter) {}
  /// Letters and counting of a machine.
  explicit GcodeReader(const MachineModel& machine)
      : tilt_(machine.tilt.letter),
        rotary_(machine.rotary.letter),
        tilt_word_(machine.tilt.word),
        rotary_word_(machine.rotary.word),
        top_(machine.z.max) {}

  /// The blocks of a line, in order of execution (M3 before the move, M2 after it); none for blank, comment
  /// or purely modal lines. An arc is given in straight pieces (arc_way.h), all but the last of which go on;
  /// its centre is from its start (I J K). Errors: kInput with the word that is wrong: unknown letter or
  /// code, number malformed, feed move without F (G93 wants F on each), an arc that no control takes, inches.
  Result<std::vector<Block>> read_line(std::string_view line);
  /// The same, appended to `blocks`, for many lines.
  Result<void> read_line(std::string_view line, std::vector<Block>& blocks);

  /// G91 too, as controllers know it. Judges of programs refuse it: a posted program has no relative word.
  GcodeReader& with_relative() {
    relative_known_ = true;
    return *this;
  }

  Fault fault() const { return fault_; }  ///< of the last line
  bool ended() const { return ended_; }   ///< M2 or M30 was read
  const ModalState& modal() const { return modal_; }
  /// The axes stand here, whatever the blocks said (a stop, a reset).
  void set_position(const Joints& at) { modal_.at = at; }
  /// Z where the machine's own coordinates have 0, in the program's: another work offset moves it.
  void set_top(double top) { top_ = top; }

 private:
  char tilt_, rotary_;
  RotaryWord tilt_word_ = RotaryWord::kAccumulate, rotary_word_ = RotaryWord::kAccumulate;
  double top_ = 0.0;  ///< Z where the machine's own coordinates have 0: the end of its travel
  ModalState modal_;
  Fault fault_ = Fault::kNone;
  bool ended_ = false, relative_known_ = false;
  std::uint32_t lines_ = 0;
  std::string text_;  ///< the line without blanks and comments, upper case
};

/// Target of a rotary at position `at` (degrees, turns counted) when the control reads `word`.
double turned_to(RotaryWord counting, double word, double at);

/// A whole program, up to M2, M30, the closing % or the end of the text; the stream may be left beyond it.
/// Calls take(block) as they are read. Errors: kInput with `name`:line; kIo.
Result<void> read_program(std::istream& in, const std::string& name, GcodeReader reader,
                          const std::function<void(const Block&)>& take);
/// All of its blocks.
Result<std::vector<Block>> read_program(std::istream& in, const std::string& name, GcodeReader reader);
Result<std::vector<Block>> read_program(std::istream& in, const std::string& name, char tilt_letter,
                                        char rotary_letter);

}  // namespace tiltfeed::sim
