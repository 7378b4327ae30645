#pragma once
// What programs that work for the desk say of themselves: a line of progress, the words before they fail.

#include <optional>
#include <string>

namespace tiltfeed::desk {

struct ProgressText {
  int percent = 0;
  std::string stage;
};
/// "  7 stage   ": what `--progress FILE` holds; nothing where it is no such line.
std::optional<ProgressText> parse_progress(const std::string& line);

/// What follows the last `mark` at a line's start, `hidden` taken out; of an empty text that there was none.
std::string last_words(const std::string& said, const std::string& mark, const std::string& hidden);

}  // namespace tiltfeed::desk
