#pragma once
// Engagement as a table: CSV, a row for each span at feed.

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "sim/engagement/engagement.h"

namespace tiltfeed::sim {

inline constexpr const char* kEngagementColumns =
    "operation,first_block,first_share,last_block,last_share,way_mm,volume_mm3,angle_deg,depth_mm,"
    "chip_mm_per_min,edge_load_mm,turn_load_mm2,asked_s,took_s";

/// Of one block a place: how many blocks of its operation come behind it, and the share of its way.
struct BlockPlace {
  std::uint64_t behind = 0;
  double share = 0.0;
};

/// Where on the program's blocks a path's moves are: of a block that is several moves each has its share by
/// the time that F asks for.
class BlockPlaces {
 public:
  explicit BlockPlaces(const ExecutedPath& path);
  BlockPlace at(std::uint32_t move, double share) const;

 private:
  struct Part {
    std::uint64_t behind = 0;
    double begin = 0.0, end = 1.0;
  };
  std::vector<Part> moves_;
};

/// `operation`: counted from 1. Blocks are counted from the operation's last one, which is 0: what stands
/// before its first differs between controls.
void write_engagement(std::size_t operation, const ExecutedPath& path, const Engagement& engagement,
                      std::ostream& out);

}  // namespace tiltfeed::sim
