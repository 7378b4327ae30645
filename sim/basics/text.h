#pragma once
// What a report says in words and numbers.

#include <array>
#include <cstdio>
#include <string>

namespace tiltfeed::sim {

/// By a printf format; of more than 1199 bytes the rest is left out.
std::string text(const char* format, auto... values) {
  std::array<char, 1200> line;
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

}  // namespace tiltfeed::sim
