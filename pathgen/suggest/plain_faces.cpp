#include "pathgen/suggest/plain_faces.h"

#include <array>
#include <cmath>
#include <map>

namespace tiltfeed::pathgen {

namespace {

/// A face of this share of the surface or more is large.
constexpr double kLarge = 0.04;
/// Where less than this share is left, plain faces count like any other.
constexpr double kLeastLeft = 0.15;
/// Normals and distances, as shares of the part's size, that agree to this are one face's.
constexpr double kRounding = 2e-3;
/// A cylinder's normals are square to its axis (sine).
constexpr double kSquare = 0.02;

/// Which of the faces that a feature has a place is on; zeros for none of it.
using Key = std::array<long long, 4>;

}  // namespace

std::vector<double> weights_of(const Mesh& mesh, std::span<const ReachPlace> places,
                               std::span<const Feature> features, double size) {
  const auto round = [](double v) { return std::llround(v / kRounding); };
  std::vector<std::vector<Key>> keys(places.size());
  std::map<Key, double> areas;
  double whole = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const ReachPlace& p = places[i];
    whole += p.area;
    keys[i].push_back({round(p.normal.x), round(p.normal.y), round(p.normal.z),
                       round(dot(from_origin(p.place), p.normal) / size)});
    const double slack = std::max(kMeets * size, facet_slack(mesh, p.facet));
    for (std::size_t f = 0; f < features.size(); ++f) {
      if (features[f].mode != AxisMode::kLine) continue;
      const Vec3 a = features[f].axis, from = p.place - features[f].centre, across = cross(p.normal, a);
      if (std::abs(dot(p.normal, a)) > kSquare || std::abs(dot(from, across)) > slack) continue;
      // No normal has such a length.
      keys[i].push_back({static_cast<long long>(f), 1'000'000, dot(from, p.normal) > 0.0 ? 1 : -1,
                         round(length(from - a * dot(from, a)) / size)});
    }
    for (const Key& key : keys[i]) areas[key] += p.area;
  }
  // A face's distance may fall on either side of where it is rounded.
  const auto face = [&](Key key) {
    double area = 0.0;
    for (const long long off : {-1, 0, 1}) {
      Key beside = key;
      beside[3] += off;
      if (const auto found = areas.find(beside); found != areas.end()) area += found->second;
    }
    return area;
  };
  std::vector<double> weights;
  double left = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    bool plain = false;
    for (const Key& key : keys[i]) plain = plain || face(key) >= kLarge * whole;
    weights.push_back(plain ? kPlainShare * places[i].area : places[i].area);
    left += plain ? 0.0 : places[i].area;
  }
  if (left < kLeastLeft * whole)
    for (std::size_t i = 0; i < places.size(); ++i) weights[i] = places[i].area;
  return weights;
}

}  // namespace tiltfeed::pathgen
