#pragma once
// A path some of whose moves are others now, which keeps its feeds where they were.

#include <cstdint>
#include <vector>

#include "kinematics/basics/tool_path.h"

namespace tiltfeed {

/// Puts the moves of a path together in order: those that stay, and others in the place of some.
class PathSplice {
 public:
  explicit PathSplice(const ToolPath& path) : path_(path), out_(path), place_(path.moves.size() + 1) {
    out_.moves.clear();
  }
  /// `moves` stand for the path's moves `first` + 1 and on, one for each whose `original` is not 0; the
  /// others lie between. What is before and was not replaced stays. Requires: original[i] belongs to
  /// moves[i]; `first` is not before the end of the piece before.
  void replace(std::size_t first, const std::vector<Move>& moves, const std::vector<std::uint8_t>& original);
  /// The rest stays. Each change of feed is at the first move that stands for its own.
  ToolPath finish();

 private:
  void keep_to(std::size_t end);

  const ToolPath& path_;
  ToolPath out_;
  std::vector<std::uint32_t> place_;  ///< of each move of the path among the others
  std::size_t next_ = 0;              ///< of the path, the first that is not put there yet
};

}  // namespace tiltfeed
