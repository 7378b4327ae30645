#pragma once
// The lines of a program that are not motion blocks, each before which block it stands.

#include <cstdint>
#include <string>
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
};

struct Layout {
  std::vector<Insert> inserts;  ///< by rising block
  std::vector<Span> spans;      ///< of the operations
  std::size_t blocks = 0;
};

/// Requires: every operation has a block, its first a rapid.
Layout lay_out(const Posting& posting);

}  // namespace tiltfeed::daemon
