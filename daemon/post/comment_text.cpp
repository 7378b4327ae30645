#include "daemon/post/comment_text.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/decimal.h"
#include "kinematics/basics/units.h"

namespace tiltfeed::daemon {
namespace {

constexpr std::size_t kMaxName = 40;
// A fixture nearer than this to no rotation is none.
constexpr double kNoRotation = 1e-11;

}  // namespace

std::string plain(std::string_view text) {
  std::string kept;
  for (const char c : text) {
    const bool allowed = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                         c == ' ' || c == '.' || c == '_' || c == '-';
    if (allowed && kept.size() < kMaxName) kept += c;
  }
  return kept;
}

Vec3 fixture_degrees(const Rotation& r) {
  const double level = std::hypot(r.rows[0].x, r.rows[1].x);
  const double y = std::atan2(-r.rows[2].x, level);
  const bool locked = level < kNoRotation;  // x and z are one: all of it to z
  const double x = locked ? 0.0 : std::atan2(r.rows[2].y, r.rows[2].z);
  const double z = locked ? std::atan2(-r.rows[0].y, r.rows[1].y) : std::atan2(r.rows[1].x, r.rows[0].x);
  return Vec3{x, y, z} * (180.0 / kPi);
}

bool turns(const Rotation& r) {
  const Rotation none;
  double worst = 0.0;
  for (std::size_t i = 0; i < 3; ++i) worst = std::max(worst, length(r.rows[i] - none.rows[i]));
  return worst > kNoRotation;
}

std::string triple(Vec3 v, int decimals) {
  return decimal(v.x, decimals) + " " + decimal(v.y, decimals) + " " + decimal(v.z, decimals);
}

}  // namespace tiltfeed::daemon
