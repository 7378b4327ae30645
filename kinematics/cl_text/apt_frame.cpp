#include "kinematics/cl_text/apt_frame.h"

#include <array>
#include <cmath>

namespace tiltfeed {
namespace {

// Files print directions with four decimals or more.
constexpr double kPrinted = 1e-3;

/// A frame of the directions x and y, made unit and square.
AptVerdict frame_of(const AptRecord& record, Vec3 x, Vec3 y, Vec3 origin, AptFrame& frame) {
  if (!(std::abs(length(x) - 1.0) < kPrinted && std::abs(length(y) - 1.0) < kPrinted &&
        std::abs(dot(x, y)) < kPrinted))
    return mistake(record.word + "/: its axes are not of length 1 and square to each other");
  const Vec3 ex = normalized(x), ez = normalized(cross(ex, y));
  frame.turn = transposed(Rotation{{ex, cross(ez, ex), ez}});
  frame.origin = origin;
  return std::nullopt;
}

}  // namespace

AptVerdict read_msys(const AptRecord& record, double unit_mm, AptFrame& frame) {
  std::array<double, 9> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count != v.size()) return mistake("MSYS/ wants an origin and two directions: nine numbers");
  return frame_of(record, {v[3], v[4], v[5]}, {v[6], v[7], v[8]}, Vec3{v[0], v[1], v[2]} * unit_mm, frame);
}

AptVerdict read_csys(const AptRecord& record, double unit_mm, AptFrame& frame) {
  std::array<double, 12> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count != v.size()) return mistake("CSYS/ wants three rows of four numbers");
  const Vec3 z{v[2], v[6], v[10]};
  if (auto bad =
          frame_of(record, {v[0], v[4], v[8]}, {v[1], v[5], v[9]}, Vec3{v[3], v[7], v[11]} * unit_mm, frame))
    return bad;
  if (length(frame.turn * Vec3{0, 0, 1} - z) < kPrinted) return std::nullopt;
  return mistake("CSYS/: its third axis is not that of a right-handed frame");
}

}  // namespace tiltfeed
