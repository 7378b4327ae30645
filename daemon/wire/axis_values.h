#pragma once
// Places of axes by their letters, as reports and program words state them.

#include <array>
#include <string>
#include <string_view>

namespace tiltfeed::daemon {

/// Axes in this order; what is not known is not a number. A B C are rotary, the others linear.
inline constexpr std::string_view kAxisLetters = "XYZABCUVW";
inline constexpr std::size_t kMostAxes = kAxisLetters.size();
using AxisValues = std::array<double, kMostAxes>;
AxisValues no_axes();
/// X Y Z U V W; A B C are rotary.
constexpr bool is_linear_axis(std::size_t axis) { return axis < 3 || axis > 5; }
/// "X1 Y-2.5": the axes that are known, three decimals.
std::string describe(const AxisValues& axes);

}  // namespace tiltfeed::daemon
