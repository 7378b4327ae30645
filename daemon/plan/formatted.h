#pragma once
// A line of a report as printf would print it.

#include <cstdio>
#include <string>

namespace tiltfeed::daemon {

/// At most 511 bytes.
std::string formatted(const char* pattern, auto... values) {
  char text[512];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

}  // namespace tiltfeed::daemon
