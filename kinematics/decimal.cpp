#include "kinematics/decimal.h"

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace tiltfeed {
namespace {

constexpr std::array<double, kMaxDecimals + 1> kScales{1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
// Scaled values up to 2^52 are exact integers in a double.
constexpr double kExact = 4503599627370496.0;

// Between 2^52 and 2^53 a double has no fraction: adding this rounds what is added, ties to even.
constexpr double kRounder = 1.5 * kExact;

/// std::nearbyint without the call.
double nearest_integer(double value) {
  if (!(std::abs(value) < kExact / 2.0)) return std::nearbyint(value);
  return (value + kRounder) - kRounder;
}

char* trim(char* first, char* last) {
  while (last > first && last[-1] == '0') --last;
  if (last > first && last[-1] == '.') --last;
  return last;
}

}  // namespace

double decimal_scale(int decimals) {
  assert(decimals >= 0 && decimals <= kMaxDecimals);
  return kScales[static_cast<std::size_t>(decimals)];
}

double round_decimal(double value, int decimals) {
  const double scale = decimal_scale(decimals);
  const double scaled = nearest_integer(value * scale);
  if (!(std::abs(scaled) < kExact)) return value;
  return scaled / scale + 0.0;  // + 0.0 turns -0 into 0
}

char* write_decimal(char* out, double value, int decimals) {
  assert(std::isfinite(value));
  const double scaled = nearest_integer(value * decimal_scale(decimals));
  if (!(std::abs(scaled) < kExact)) {
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

}  // namespace tiltfeed
