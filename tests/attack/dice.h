#pragma once
// Random numbers whose values do not depend on the library.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <random>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/units.h"

namespace tiltfeed::attack {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed * 0x9E3779B97F4A7C15u + 20051123u) {}

  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  /// As likely between 1 and 2 as between 10 and 20.
  double spread(double low, double high) { return low * std::pow(high / low, unit()); }
  /// 0 to n - 1.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(unit() * static_cast<double>(n)); }
  bool chance(double probability) { return unit() < probability; }
  template <class T>
  T one_of(std::initializer_list<T> all) {
    return *std::next(all.begin(), static_cast<std::ptrdiff_t>(below(all.size())));
  }
  Vec3 direction() {
    const double z = uniform(-1.0, 1.0), turn = uniform(0.0, 2.0 * kPi), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(turn), r * std::sin(turn), z};
  }
  /// Along a coordinate axis, either way.
  Vec3 main_direction() {
    const double s = chance(0.5) ? 1.0 : -1.0;
    return one_of<Vec3>({{s, 0, 0}, {0, s, 0}, {0, 0, s}});
  }
  std::uint64_t bits() { return random_(); }

 private:
  std::mt19937_64 random_;
};

}  // namespace tiltfeed::attack
