#pragma once
// A program walked block by block without a wire: machine time, one block with all that is in force, and
// which planned move it is.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "config/machine_profile.h"
#include "daemon/program/line_reader.h"
#include "daemon/program/link_kind.h"
#include "daemon/program/numeric_block.h"

namespace tiltfeed::daemon {

/// Modbus links count numeric blocks, every other link lines.
constexpr bool counts_numeric_blocks(LinkKind kind) { return is_ring(kind) || is_drive(kind); }

/// One block as its link counts it: a numeric block (Modbus) or a line (Grbl).
struct WalkedBlock {
  std::uint64_t block = 0;  ///< counted from 1
  std::uint64_t line = 0;   ///< of the file
  std::string text;         ///< of that line, as sent
  std::uint64_t moves = 0;  ///< motion blocks of the path up to and with this one, without its retract and
                            ///< the way to its first block: entry of the block map, counted from 1
  bool is_move = false;
  NumericBlock state;    ///< axes, feed, modes in force at the block's end
  double seconds = 0.0;  ///< machine time from the program's start to the block's end
};

/// Reads a program from its start, once. Feed moves take 60/F under G93 and length/F under G94 (rotary words
/// alone: degrees), rapids as long as their slowest axis at its axis speed; accelerations are left out.
class BlockCursor {
 public:
  /// Errors: as LineReader::open.
  static Result<BlockCursor> open(const std::string& path, LinkKind kind, const MachineModel& machine);
  /// The next block; false at the end. Errors: kInput with the place: a word that has no numbers to it.
  Result<bool> next(WalkedBlock& block);

 private:
  BlockCursor(LineReader program, LinkKind kind, const MachineModel& machine)
      : program_(std::move(program)),
        by_line_(!counts_numeric_blocks(kind)),
        machine_(machine),
        reader_(numeric_axes(machine), !counts_numeric_blocks(kind)) {}
  double seconds_of(const NumericBlock& block) const;
  void pass(const NumericBlock& block);

  LineReader program_;
  bool by_line_;
  MachineModel machine_;
  BlockReader reader_;
  Line line_;
  std::vector<NumericBlock> blocks_;
  std::size_t used_ = 0;
  WalkedBlock at_;
  bool placed_ = false;  // it is known where all axes are
};

/// Block `number`. Errors: kUsage when the program has fewer; as BlockCursor.
Result<WalkedBlock> find_block(const std::string& path, LinkKind kind, const MachineModel& machine,
                               std::uint64_t number);

/// Machine time at every kStride-th block, so that 10 million blocks take 1.2 MiB.
class ProgramTime {
 public:
  static constexpr std::uint64_t kStride = 64;
  /// Errors: as BlockCursor.
  static Result<ProgramTime> read(const std::string& path, LinkKind kind, const MachineModel& machine);
  double total() const { return total_; }
  /// Machine time until that many blocks are executed, s.
  double at(std::uint64_t blocks) const;

 private:
  std::vector<double> marks_{0.0};  // at block 0, kStride, 2 kStride ...
  std::uint64_t blocks_ = 0;
  double total_ = 0.0;
};

}  // namespace tiltfeed::daemon
