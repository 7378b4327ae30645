#include "sim/control/slide_blocks.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {

namespace {
constexpr double kMostPieces = 10000.0;
}

void SlideBlocks::take(const ControlBlock& one, const std::function<void(const Block&)>& take) {
  const bool moves = one.block.op == Op::kRapid || one.block.op == Op::kFeed;
  if (!moves) return take(one.block);
  if (one.tcp != tcp_) at_ = one.tcp ? frames_.tip_words(at_) : frames_.slide_words(at_);
  const Joints from = std::exchange(at_, one.block.target);
  tcp_ = one.tcp;
  if (one.tcp && !one.fresh) return cut(one, from, take);
  Block block = one.block;
  if (one.tcp) block.target = frames_.slide_words(block.target);
  take(block);
}

void SlideBlocks::cut(const ControlBlock& one, const Joints& from,
                      const std::function<void(const Block&)>& take) const {
  const Joints& to = one.block.target;
  ProgramMove tip{from, to, false, true, 0, 0};
  ProgramMove slides{frames_.slide_words(from), frames_.slide_words(to), false, false, 0, 0};
  const Pose begin = frames_.pose(from, true), end = frames_.pose(to, true);
  const double stray = frames_.stray(tip, begin, end, reach_) + frames_.stray(slides, begin, end, reach_);
  const int pieces = static_cast<int>(std::ceil(std::clamp(std::sqrt(stray / tolerance_), 1.0, kMostPieces)));
  const double linear = std::hypot(to.x - from.x, to.y - from.y, to.z - from.z),
               way = linear > 0.0 ? linear : std::hypot(to.a - from.a, to.c - from.c);
  Block block = one.block;
  if (block.op == Op::kFeed && way > 0.0) {
    // F is the tip's; each piece takes its share of that time.
    block.feed = (one.block.inverse_time ? one.block.feed : one.block.feed / way) * pieces;
    block.inverse_time = true;
  }
  for (int i = 1; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / pieces;
    block.target = frames_.slide_words({from.x + share * (to.x - from.x), from.y + share * (to.y - from.y),
                                        from.z + share * (to.z - from.z), from.a + share * (to.a - from.a),
                                        from.c + share * (to.c - from.c)});
    block.goes_on = i < pieces;
    block.exact_stop = one.block.exact_stop && i == pieces;
    take(block);
  }
}

}  // namespace tiltfeed::sim
