#include "kinematics/joints/path_splice.h"

#include <utility>

namespace tiltfeed {

void PathSplice::keep_to(std::size_t end) {
  for (; next_ < end; ++next_) {
    place_[next_] = static_cast<std::uint32_t>(out_.moves.size());
    out_.moves.push_back(path_.moves[next_]);
  }
}

void PathSplice::replace(std::size_t first, const std::vector<Move>& moves,
                         const std::vector<std::uint8_t>& original) {
  keep_to(first + 1);
  bool begins = true;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    if (begins) place_[next_] = static_cast<std::uint32_t>(out_.moves.size());
    out_.moves.push_back(moves[i]);
    begins = original[i] != 0;
    if (begins) ++next_;
  }
}

ToolPath PathSplice::finish() {
  keep_to(path_.moves.size());
  for (FeedChange& change : out_.feeds) change.move = place_[change.move];
  return std::move(out_);
}

}  // namespace tiltfeed
