#include "pathgen/free_axis/pass_curve.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {
/// The least length (mm) over which feed and normal are told: at corners of the pass they have no value.
constexpr double kLeastWindow = 1e-3;
}  // namespace

PassCurve::PassCurve(const ClChain& chain, const FreeAxis& wish) : chain_(chain), wish_(wish) {
  way_.push_back(0.0);
  sum_.push_back({});
  for (std::size_t i = 1; i < chain.points.size(); ++i) {
    const double step = distance(chain.points[i - 1].centre, chain.points[i].centre);
    way_.push_back(way_.back() + step);
    sum_.push_back(sum_.back() + (chain.points[i - 1].normal + chain.points[i].normal) * (step / 2.0));
  }
}

std::size_t PassCurve::index(double way) const {
  const auto after = std::upper_bound(way_.begin(), way_.end(), way);
  auto i = std::clamp<std::size_t>(static_cast<std::size_t>(after - way_.begin()), 1, way_.size() - 1);
  while (i > 1 && way_[i] == way_[i - 1]) --i;  // the pass ends with the same place twice
  return i;
}

ClPoint PassCurve::at(double way) const {
  const std::size_t i = index(way);
  const double f = std::clamp((way - way_[i - 1]) / (way_[i] - way_[i - 1]), 0.0, 1.0);
  const ClPoint &a = chain_.points[i - 1], &b = chain_.points[i];
  const Vec3 n = a.normal * (1.0 - f) + b.normal * f;
  return {lerp(a.centre, b.centre, f), squared_length(n) > 1e-12 ? normalized(n) : a.normal,
          f < 0.5 ? a.facet : b.facet};
}

Vec3 PassCurve::normals_up_to(double way) const {
  double rounds = 0.0;
  if (chain_.closed) rounds = std::floor(way / length()), way -= rounds * length();
  way = std::clamp(way, 0.0, length());
  const std::size_t i = index(way);
  const double f = (way - way_[i - 1]) / (way_[i] - way_[i - 1]);
  const ClPoint &a = chain_.points[i - 1], &b = chain_.points[i];
  const Vec3 part = a.normal * (f - f * f / 2.0) + b.normal * (f * f / 2.0);
  return sum_[i - 1] + part * (way_[i] - way_[i - 1]) + sum_.back() * rounds;
}

Vec3 PassCurve::wished(double way) const {
  const double half = std::max(wish_.smoothing, kLeastWindow) / 2.0;
  const auto place = [&](double w) {
    return at(chain_.closed ? w - std::floor(w / length()) * length() : std::clamp(w, 0.0, length())).centre;
  };
  const Vec3 sum = normals_up_to(way + half) - normals_up_to(way - half);
  const Vec3 n = squared_length(sum) > 1e-12 ? normalized(sum) : at(way).normal;
  Vec3 feed = place(way + half) - place(way - half);
  feed = feed - n * dot(feed, n);
  if (squared_length(feed) < 1e-18) return n;
  feed = normalized(feed);
  return normalized(n + feed * std::tan(wish_.lead.radians()) +
                    cross(n, feed) * std::tan(wish_.lean.radians()));
}

}  // namespace tiltfeed::pathgen
