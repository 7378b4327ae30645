#pragma once
// Numbers as decimal text, fast and the same everywhere: no locale, no exponent, never "-0".

#include <string>

namespace tiltfeed {

/// Decimals that the functions below take: 10^9 scales any travel of a machine into an exact integer.
inline constexpr int kMaxDecimals = 9;
/// Bytes that `write_decimal` may need.
inline constexpr int kDecimalSpace = 352;

/// 10^decimals. Requires: 0 <= decimals <= kMaxDecimals.
double decimal_scale(int decimals);

/// The multiple of 10^-decimals nearest to `value`: the very double that its decimal text reads back as.
double round_decimal(double value, int decimals);

/// Writes `value` rounded to at most `decimals` decimals, trailing zeros trimmed; returns the end.
/// Requires: value finite, kDecimalSpace bytes at `out`.
char* write_decimal(char* out, double value, int decimals);

std::string decimal(double value, int decimals);

}  // namespace tiltfeed
