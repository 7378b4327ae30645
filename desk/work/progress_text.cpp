#include "desk/work/progress_text.h"

#include <algorithm>
#include <charconv>

namespace tiltfeed::desk {

std::optional<ProgressText> parse_progress(const std::string& line) {
  if (line.size() <= 4) return std::nullopt;
  ProgressText text;
  const std::size_t digits = std::min(line.find_first_not_of(' '), std::size_t{3});
  std::from_chars(line.data() + digits, line.data() + 3, text.percent);
  text.stage = line.substr(4);
  text.stage.erase(text.stage.find_last_not_of(' ') + 1);
  return text;
}

std::string last_words(const std::string& said, const std::string& mark, const std::string& hidden) {
  const std::size_t at = said.rfind("\n" + mark);
  std::string words = at != std::string::npos    ? said.substr(at + 1 + mark.size())
                      : said.rfind(mark, 0) == 0 ? said.substr(mark.size())
                                                 : said;
  while (!words.empty() && words.back() == '\n') words.pop_back();
  for (std::size_t i = words.find(hidden); i != std::string::npos && !hidden.empty();
       i = words.find(hidden, i))
    words.erase(i, hidden.size());
  return words.empty() ? "the program ended without a word; is there memory enough?" : words;
}

}  // namespace tiltfeed::desk
