#pragma once
// The lines of a program that are not motion blocks, each before which block it stands.

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/post/dialect.h"
#include "daemon/post/posting.h"

namespace tiltfeed::daemon {

/// A line that is no motion block.
struct Insert {
  std::size_t block = 0;  ///< before this block of the program; the number of blocks: behind the last
  std::string text;
  bool numbered = true;
};

/// An operation's share of the program's blocks.
struct Span {
  std::size_t first = 0, last = 0;
  std::string first_words;  ///< in front of the axes of its first block, with a blank
  /// Blocks, counted from `first`, with a word of cutter compensation.
  std::vector<std::pair<std::size_t, const char*>> sides{};

  /// That of a block, with a blank in front; empty: none.
  std::string_view side(std::size_t block) const {
    const auto at = std::lower_bound(sides.begin(), sides.end(), block,
                                     [](const auto& one, std::size_t wanted) { return one.first < wanted; });
    return at != sides.end() && at->first == block ? at->second : "";
  }
};

struct Layout {
  std::vector<Insert> inserts;  ///< by rising block
  std::vector<Span> spans;      ///< of the operations
  std::size_t blocks = 0;
};

/// Requires: every operation has a block, its first a rapid.
Layout lay_out(const Posting& posting);

}  // namespace tiltfeed::daemon
