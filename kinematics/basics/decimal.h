#pragma once
// Numbers as decimal text, fast and the same everywhere: no locale, no exponent, never "-0".

#include <array>
#include <cassert>
#include <cmath>
#include <string>

#include "kinematics/basics/geometry.h"

namespace tiltfeed {

/// Decimals that the functions below take: 10^9 scales any travel of a machine into an exact integer.
inline constexpr int kMaxDecimals = 9;
/// Bytes that `write_decimal` may need.
inline constexpr int kDecimalSpace = 352;

/// 10^decimals. Requires: 0 <= decimals <= kMaxDecimals.
inline double decimal_scale(int decimals) {
  constexpr std::array<double, kMaxDecimals + 1> kScales{1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
  assert(decimals >= 0 && decimals <= kMaxDecimals);
  return kScales[static_cast<std::size_t>(decimals)];
}

/// Scaled values below 2^52 are exact integers in a double.
inline constexpr double kExactUnits = 4503599627370496.0;

/// std::nearbyint without the call.
inline double nearest_integer(double value) {
  // Between 2^52 and 2^53 a double has no fraction: adding this rounds what is added, ties to even.
  constexpr double kRounder = 1.5 * kExactUnits;
  if (!(std::abs(value) < kExactUnits / 2.0)) return std::nearbyint(value);
  return (value + kRounder) - kRounder;
}

/// The multiple of 10^-decimals nearest to `value`: the very double that its decimal text reads back as.
inline double round_decimal(double value, int decimals) {
  const double scale = decimal_scale(decimals), scaled = nearest_integer(value * scale);
  if (!(std::abs(scaled) < kExactUnits)) return value;
  return scaled / scale + 0.0;  // + 0.0 turns -0 into 0
}

/// Writes `value` rounded to at most `decimals` decimals, trailing zeros trimmed; returns the end.
/// Requires: value finite, kDecimalSpace bytes at `out`.
char* write_decimal(char* out, double value, int decimals);

std::string decimal(double value, int decimals);

/// To so many significant digits: how messages print a number.
std::string number_text(double value, int digits = 4);

/// "(1.5, -2, 0.25)", to seven digits: how messages name a place.
std::string to_string(Point<Part> p);

}  // namespace tiltfeed
