#include "tests/attack/written.h"

#include <cstdarg>
#include <cstdio>

namespace tiltfeed::attack {

std::string formatted(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}
std::string vector(const char* key, Vec3 v) {
  return formatted("%s: [%.9f, %.9f, %.9f]\n", key, v.x, v.y, v.z);
}
std::string interval(const char* key, double low, double high) {
  return formatted("  %s: [%.6f, %.6f]\n", key, low, high);
}

}  // namespace tiltfeed::attack
