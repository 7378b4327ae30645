#pragma once
// A piece of a file in the messages of its readers.

#include <string>
#include <string_view>

namespace tiltfeed::pathgen {

/// In quotes, cut off when it is long; what is not visible ASCII becomes a question mark.
inline std::string quote(std::string_view text) {
  constexpr std::size_t kLongest = 24;
  std::string out = "\"";
  for (const char c : text.substr(0, kLongest)) out += c > ' ' && c < 127 ? c : '?';
  return out + (text.size() > kLongest ? "...\"" : "\"");
}

}  // namespace tiltfeed::pathgen
