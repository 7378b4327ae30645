#pragma once
// Two numbers side by side, and vectors of them: what is asked of many places alike is computed for
// two at a time.

#include "kinematics/geometry.h"

namespace tiltfeed {

using Twin = double __attribute__((vector_size(16)));

struct TwinVec3 {
  Twin x, y, z;
  TwinVec3(Twin x_, Twin y_, Twin z_) : x(x_), y(y_), z(z_) {}
  TwinVec3(Vec3 v) : x{v.x, v.x}, y{v.y, v.y}, z{v.z, v.z} {}
};

inline TwinVec3 operator+(TwinVec3 a, TwinVec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline TwinVec3 operator-(TwinVec3 a, TwinVec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline TwinVec3 operator*(Vec3 a, Twin k) { return {a.x * k, a.y * k, a.z * k}; }
inline TwinVec3 operator*(TwinVec3 a, Twin k) { return {a.x * k, a.y * k, a.z * k}; }
inline TwinVec3 operator*(TwinVec3 a, double k) { return {a.x * k, a.y * k, a.z * k}; }
inline Twin dot(TwinVec3 a, TwinVec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline TwinVec3 cross(TwinVec3 a, TwinVec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Twin squared_length(TwinVec3 a) { return dot(a, a); }

#ifdef __SSE2__
inline Twin lesser(Twin a, Twin b) { return __builtin_ia32_minpd(a, b); }
inline Twin greater(Twin a, Twin b) { return __builtin_ia32_maxpd(a, b); }
#else
inline Twin lesser(Twin a, Twin b) { return a < b ? a : b; }
inline Twin greater(Twin a, Twin b) { return a > b ? a : b; }
#endif
inline double greatest(Twin a) { return std::max(a[0], a[1]); }

}  // namespace tiltfeed
