#include "daemon/wire/axis_values.h"

#include <cmath>
#include <limits>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {

namespace {
constexpr int kPrinted = 3;
}  // namespace

AxisValues no_axes() {
  AxisValues axes;
  axes.fill(std::numeric_limits<double>::quiet_NaN());
  return axes;
}

std::string describe(const AxisValues& axes) {
  std::string text;
  for (std::size_t i = 0; i < kMostAxes; ++i)
    if (!std::isnan(axes[i]))
      text += (text.empty() ? "" : " ") + std::string(1, kAxisLetters[i]) + decimal(axes[i], kPrinted);
  return text;
}

}  // namespace tiltfeed::daemon
