#pragma once
// A plain Modbus drive, as many are: one write of several registers, the last of which sets the axes off; a
// status register; a register that stops. It numbers nothing and remembers nothing. Registers in, blocks out,
// simulated time, no I/O. Its registers are in sim/controller/README.md.

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sim/controller/modbus_controller.h"
#include "sim/motion/motion.h"

namespace tiltfeed::sim {

struct DriveOptions {
  std::uint16_t block = 0x6200, status = 0x1003, stop = 0x6002;  ///< registers
  std::uint16_t words = 8, trigger = 0x0010, stop_value = 0x0040;
  std::array<int, 5> place{1, -1, -1, -1,
                           -1};  ///< of X Y Z tilt rotary in the write; -1: it has no such axis
  double counts = 1000.0;        ///< per mm and degree
  int feed_place = 3;            ///< of the speed, mm/min
  double reaction = 0.0;         ///< s from a write until the status says that it moves
};

/// Properties: each write that ends with the trigger is a move, however often the same words come; a write
/// while it moves takes the place of that move.
class DriveController {
 public:
  DriveController(const MachineModel& machine, const DriveOptions& options, Motion::Sink sink);

  Access write(std::uint16_t address, std::span<const std::uint16_t> words);
  Access read(std::uint16_t address, std::span<std::uint16_t> words) const;
  /// Requires: now >= this->now().
  void advance(double now);
  double now() const { return motion_.now(); }

  void raise_alarm() { alarm_ = true, motion_.stop(); }
  const Motion& motion() const { return motion_; }
  std::uint64_t moves() const { return moves_; }        ///< that were set off
  std::uint64_t replaced() const { return replaced_; }  ///< of these, cut short by the next one

 private:
  DriveOptions options_;
  Motion motion_;
  std::optional<Block> waiting_;  ///< taken, not begun
  double begins_ = 0.0;
  bool alarm_ = false;
  std::uint64_t moves_ = 0, replaced_ = 0;
};

}  // namespace tiltfeed::sim
