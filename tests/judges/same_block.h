#pragma once
// Whether a block that was executed is the program's.

#include <cmath>

#include "sim/gcode/gcode_reader.h"

namespace tiltfeed {

inline bool same_block(const sim::Block& a, const sim::Block& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) < 1e-9; };
  if (a.op != b.op || a.m_code != b.m_code) return false;
  if (a.op == sim::Op::kMCode) return true;
  return near(a.target.x, b.target.x) && near(a.target.y, b.target.y) && near(a.target.z, b.target.z) &&
         near(a.target.a, b.target.a) && near(a.target.c, b.target.c) && near(a.feed, b.feed) &&
         a.inverse_time == b.inverse_time;
}

}  // namespace tiltfeed
