#pragma once
// What a number of a settings file may be.

namespace tiltfeed::config {

struct Range {
  double min = 0.0, max = 0.0;
  bool above_min = false;   ///< min itself is out of range
  bool below_max = false;   ///< max itself is out of range
  const char* reason = "";  ///< why min is the limit, where that is not plain
};
constexpr Range above(double min, double max) { return {min, max, true}; }
constexpr Range between(double min, double max) { return {min, max, true, true}; }

}  // namespace tiltfeed::config
