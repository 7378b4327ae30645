#pragma once
// A block of the program as the registers of a plain Modbus drive (DriveMap of config/link_profile.h).

#include <cstdint>
#include <optional>
#include <vector>

#include "config/link_profile.h"
#include "daemon/program/numeric_block.h"

namespace tiltfeed::daemon {

/// Knows where the block before ended: a feed per block is a speed only with the way.
class DriveEncoder {
 public:
  explicit DriveEncoder(const config::DriveMap& map) : map_(map) {}
  /// The words of a move, from register map.block on; none for a dwell, M0 M1 M6 and M2 M30, which move
  /// nothing. Errors: kInput for what the drive has not (an axis that moves, spindle, coolant), for inverse
  /// time in the first move; kLimit for what does not fit its register.
  Result<std::vector<std::uint16_t>> encode(const NumericBlock& block);

 private:
  Result<double> speed(const NumericBlock& block) const;
  void put(std::vector<std::uint16_t>& words, int place, int value) const;

  config::DriveMap map_;
  std::optional<NumericBlock> before_;  ///< the move before
};

}  // namespace tiltfeed::daemon
