#include "kinematics/basics/decimal.h"

#include <charconv>
#include <cstdint>

namespace tiltfeed {
namespace {

char* trim(char* first, char* last) {
  while (last > first && last[-1] == '0') --last;
  if (last > first && last[-1] == '.') --last;
  return last;
}

}  // namespace

char* write_decimal(char* out, double value, int decimals) {
  assert(std::isfinite(value));
  const double scaled = nearest_integer(value * decimal_scale(decimals));
  if (!(std::abs(scaled) < kExactUnits)) {
    char* const end = std::to_chars(out, out + kDecimalSpace, value, std::chars_format::fixed, decimals).ptr;
    return decimals == 0 ? end : trim(out, end);
  }
  auto units = static_cast<std::int64_t>(scaled);
  if (units < 0) {
    *out++ = '-';
    units = -units;
  }
  const auto scale = static_cast<std::int64_t>(decimal_scale(decimals));
  const std::int64_t whole = units / scale;
  std::int64_t fraction = units % scale;
  out = std::to_chars(out, out + 20, whole).ptr;
  if (fraction == 0) return out;
  int digits = decimals;
  while (fraction % 10 == 0) {
    fraction /= 10;
    --digits;
  }
  *out++ = '.';
  for (int i = digits - 1; i >= 0; --i) {
    out[i] = static_cast<char>('0' + fraction % 10);
    fraction /= 10;
  }
  return out + digits;
}

std::string decimal(double value, int decimals) {
  if (!std::isfinite(value)) return "not a number";
  std::array<char, kDecimalSpace> text;
  return {text.data(), write_decimal(text.data(), value, decimals)};
}

std::string number_text(double value, int digits) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits).ptr};
}

std::string to_string(Point<Part> p) {
  return "(" + number_text(p.x, 7) + ", " + number_text(p.y, 7) + ", " + number_text(p.z, 7) + ")";
}

}  // namespace tiltfeed
