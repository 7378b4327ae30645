#include "sim/engagement/engagement_table.h"

#include <ostream>
#include <utility>

#include "sim/basics/text.h"

namespace tiltfeed::sim {

BlockPlaces::BlockPlaces(const ExecutedPath& path) : moves_(path.moves.size()) {
  // A block's pieces but its last are no blocks of the path, and neither is the way to and from a retract.
  std::uint64_t behind = 0;
  bool seen = false;
  for (std::size_t i = path.moves.size(); i-- > 0;) {
    if (!path.moves[i].off_path) behind += std::exchange(seen, true);
    moves_[i].behind = behind;
  }
  for (std::size_t first = 0; first < moves_.size();) {
    std::size_t end = first;
    double whole = 0.0;
    for (; end < moves_.size() && moves_[end].behind == moves_[first].behind; ++end)
      whole += path.moves[end].rapid ? 0.0 : path.moves[end].asked;
    double before = 0.0;
    for (; first < end; ++first) {
      if (path.moves[first].rapid || !(whole > 0.0)) continue;
      moves_[first].begin = before / whole;
      before += path.moves[first].asked;
      moves_[first].end = before / whole;
    }
  }
}

BlockPlace BlockPlaces::at(std::uint32_t move, double share) const {
  const Part& part = moves_[move];
  return {part.behind, part.begin + share * (part.end - part.begin)};
}

void write_engagement(std::size_t operation, const ExecutedPath& path, const Engagement& engagement,
                      std::ostream& out) {
  const BlockPlaces places(path);
  for (std::size_t i = 0; i < engagement.spans.size(); ++i) {
    const EngagedSpan& span = engagement.spans[i];
    if (span.rapid) continue;
    const SpanEngagement& load = engagement.loads[i];
    const BlockPlace first = places.at(span.first_move, span.begin),
                     last = places.at(span.last_move, span.end);
    out << text("%zu,%llu,%.6f,%llu,%.6f,%.5f,%.6f,%.0f,%.4f,%.2f,%.6f,%.6f,%.6f,%.6f\n", operation,
                static_cast<unsigned long long>(first.behind), first.share,
                static_cast<unsigned long long>(last.behind), last.share, span.way, load.volume, load.angle,
                load.depth, load.chip, load.edge_load, load.turn_load, span.asked, span.took);
  }
}

}  // namespace tiltfeed::sim
