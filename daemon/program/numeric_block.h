#pragma once
// G-code words, and program lines as numeric blocks with the modal state resolved: what goes over Modbus.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/program/line.h"
#include "kinematics/basics/result.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

/// A letter and its number, as in G93 or.
struct GcodeWord {
  char letter = ' ';
  double value = 0.0;
};

/// No control has a G or M code from here on; what is larger must not wrap into one.
inline constexpr double kLargestCode = 1000.0;

/// Takes the first word off `rest`; nothing when `rest` is not a letter and a plain decimal number.
std::optional<GcodeWord> take_word(std::string_view& rest);

enum class BlockOp : std::uint8_t { kRapid = 1, kFeed = 2, kDwell = 3, kMCode = 4 };

/// One block with every value filled in.
struct NumericBlock {
  BlockOp op = BlockOp::kRapid;
  bool inverse_time = false;
  std::uint64_t line = 0;
  double x = 0.0, y = 0.0, z = 0.0;  ///< mm
  double tilt = 0.0, rotary = 0.0;   ///< degrees, words as programmed
  double feed = 0.0;                 ///< 1/min or mm/min
  double seconds = 0.0;              ///< dwell
  int m_code = 0;
  double spindle = 0.0;  ///< S in force, 1/min
  std::string text;      ///< the line, for messages
  /// Axes that a rapid leaves where they are: bit 0 X, 1 Y, 2 Z, 3 tilt, 4 rotary. The program has not said
  /// where; their values mean nothing.
  std::uint8_t kept = 0;
  bool machine = false;  ///< G53: the place is in machine coordinates
  /// Axes that the machine has not got, the same bits.
  std::uint8_t absent = 0;
  // Of an arc, which goes out as text alone:
  double way = 0.0;   ///< its length, mm; 0: the block is straight
  double rise = 0.0;  ///< by how much its highest place is over its end, mm
  /// Axes that a relative move (G91) has led to a place that the program does not state, the same bits.
  std::uint8_t lost = 0;
};

/// M0, M1 and M6: the machine waits for the operator.
inline bool is_operator_stop(const NumericBlock& block) {
  return block.op == BlockOp::kMCode && (block.m_code == 0 || block.m_code == 1 || block.m_code == 6);
}

/// A move to a Z that the program states in its own coordinates.
inline bool states_height(const NumericBlock& block) {
  constexpr unsigned kZ = 1U << 2U;
  const bool moves = block.op == BlockOp::kRapid || block.op == BlockOp::kFeed;
  return moves && !block.machine && ((block.kept | block.lost) & kZ) == 0;
}

/// The letters of the rotary axes that a machine has; 0: it has no such axis. Not known: A or B is the tilt,
/// C the rotary, and all five must be stated.
struct NumericAxes {
  bool known = false;
  char tilt = 0, rotary = 0;
};
NumericAxes numeric_axes(const MachineModel& machine);

/// Turns lines into numeric blocks. Knows G0 G1 (as text G2 G3 G18 G19, too) G4 (P or S: the dwell) G90 G93
/// G94 and M0-M9 M30, takes what does not change anything here (G17 G21 G40 G49 G54 G61 G64 G80 G97, N T),
/// refuses everything else: what it does not know cannot be sent as numbers.
class BlockReader {
 public:
  /// An axis that the machine has not got is 0 in every block, and no word may name it. `lines`: the program
  /// goes out as text, and is only followed: G91 is no error, its moves keep every axis and lose those they
  /// name.
  explicit BlockReader(const NumericAxes& axes = {}, bool lines = false);

  /// Appends the blocks of `line` in order of execution: spindle and coolant, dwell, move, stop.
  /// Errors: kInput with what is wrong (the caller adds the place); an axis that has no value yet when a feed
  /// move begins, which a G53 takes from it; a feed move without F; kLimit for a value that does not fit.
  Result<void> read(const Line& line, std::vector<NumericBlock>& blocks);
  /// G91 is in force.
  bool relative() const { return relative_; }
  /// An axis is where a relative move has left it; stating all of them ends that.
  bool lost() const { return lost_ != 0; }

 private:
  struct Parsed;
  Result<void> take_g(double value, Parsed& parsed);
  Result<void> take_m(double value, Parsed& parsed);
  Result<void> take_axis(const GcodeWord& word, Parsed& parsed);
  Result<void> take_other(const GcodeWord& word, Parsed& parsed);
  Result<void> add_move(const Line& line, const Parsed& parsed, std::vector<NumericBlock>& blocks);
  Result<void> take_arc(const Parsed& parsed, NumericBlock& block) const;
  void add_relative(const Line& line, const Parsed& parsed, std::vector<NumericBlock>& blocks);
  void add_m(int code, const Line& line, std::vector<NumericBlock>& blocks) const;
  std::uint8_t absent() const;
  NumericBlock block_here(BlockOp op, const Line& line) const;

  double axes_[5] = {};  // X Y Z tilt rotary
  bool known_[5] = {};   // the program has stated it
  NumericAxes names_;
  bool lines_ = false, relative_ = false;
  std::uint8_t lost_ = 0;     // axes, a bit each
  char tilt_letter_ = 0;      // A or B, whichever the program uses, where the machine is not known
  int arc_ = 0, plane_ = 17;  // G2 or G3 that is in force; the plane of arcs
  bool motion_set_ = false, rapid_ = true, inverse_time_ = false;
  double feed_ = 0.0, spindle_ = 0.0;
  int spindle_code_ = 5;  // M3, M4 or M5 in force
};

}  // namespace tiltfeed::daemon
