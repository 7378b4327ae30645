#pragma once
// Two numbers side by side, and vectors of them, or four of single precision: what is asked of many places
// alike is computed for so many at a time.

#include <cstring>

#include "kinematics/basics/geometry.h"

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

using Lanes = float __attribute__((vector_size(16)));

inline Lanes all_lanes(float v) { return Lanes{v, v, v, v}; }
inline Lanes load_lanes(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

#ifdef __SSE2__
inline Lanes lesser(Lanes a, Lanes b) { return __builtin_ia32_minps(a, b); }
inline Lanes greater(Lanes a, Lanes b) { return __builtin_ia32_maxps(a, b); }
/// Bit i: a[i] <= b[i].
inline unsigned no_more(Lanes a, Lanes b) {
  return static_cast<unsigned>(__builtin_ia32_movmskps(reinterpret_cast<Lanes>(a <= b)));
}
#else
inline Lanes lesser(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes greater(Lanes a, Lanes b) { return a > b ? a : b; }
/// Bit i: a[i] <= b[i].
inline unsigned no_more(Lanes a, Lanes b) {
  unsigned bits = 0;
  for (int i = 0; i < 4; ++i) bits |= a[i] <= b[i] ? 1u << i : 0u;
  return bits;
}
#endif
#if defined(__SSE2__) && __has_builtin(__builtin_ia32_sqrtps)
inline Lanes root(Lanes a) { return __builtin_ia32_sqrtps(a); }
#else
inline Lanes root(Lanes a) {
  return Lanes{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
}
#endif
/// b[i] where a[i] <= limit[i], else c[i].
inline Lanes where_no_more(Lanes a, Lanes limit, Lanes b, Lanes c) {
  const auto mask = a <= limit;
  using Bits = decltype(a <= limit);
  return reinterpret_cast<Lanes>((mask & reinterpret_cast<Bits>(b)) | (~mask & reinterpret_cast<Bits>(c)));
}

struct LaneVec3 {
  Lanes x, y, z;
};

inline LaneVec3 all_lanes(Vec3 v) {
  return {all_lanes(static_cast<float>(v.x)), all_lanes(static_cast<float>(v.y)),
          all_lanes(static_cast<float>(v.z))};
}
inline LaneVec3 operator+(LaneVec3 a, LaneVec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline LaneVec3 operator-(LaneVec3 a, LaneVec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline LaneVec3 operator*(LaneVec3 a, Lanes k) { return {a.x * k, a.y * k, a.z * k}; }
inline Lanes dot(LaneVec3 a, LaneVec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lanes squared_length(LaneVec3 a) { return dot(a, a); }

}  // namespace tiltfeed
