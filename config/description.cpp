#include "config/description.h"

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>

namespace tiltfeed::config {

std::string exact_text(double value) {
  std::array<char, 400> buffer;  // the smallest double needs 326 characters, the largest 309
  const double shown = value == 0.0 ? 0.0 : value;
  const auto [end, code] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), shown, std::chars_format::fixed);
  assert(code == std::errc());
  return {buffer.data(), end};
}

std::string vector_text(Vec3 v) {
  return "[" + exact_text(v.x) + ", " + exact_text(v.y) + ", " + exact_text(v.z) + "]";
}

double tidy(double value) { return std::round(value * 1e9) / 1e9; }

}  // namespace tiltfeed::config
