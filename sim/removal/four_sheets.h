#pragma once
// What four bodies that are pushed along may do to a facet, side by side: bounds in single precision, (W8) in
// sim/removal/README.md. Places are seen from an origin near the bodies.

#include "kinematics/basics/lanes.h"
#include "sim/removal/facet.h"

namespace tiltfeed::sim {

inline constexpr float kLaneFar = 1e30f;
// (W8) Rounding takes less than this share of the largest lengths from a bound.
inline constexpr float kLaneSlack = 0x1p-18f;

/// A facet, in all lanes.
struct FacetLanes {
  LaneVec3 middle, normal;
  std::array<LaneVec3, 3> out{};
  std::array<Lanes, 3> edge{};
  float radius, size;  ///< size: what it adds to the largest lengths

  /// Without its edges.
  FacetLanes(Point<Part> origin, const Patches& patches, std::uint32_t patch)
      : middle(all_lanes(patches.middle[patch] - origin)),
        normal(all_lanes(patches.normal[patch])),
        radius(patches.radius[patch]),
        size(static_cast<float>(length(patches.middle[patch] - origin)) + 2.0f * radius) {}
  FacetLanes(Point<Part> origin, const Facet& facet)
      : middle(all_lanes(facet.middle - origin)),
        normal(all_lanes(facet.normal)),
        out{all_lanes(facet.out[0]), all_lanes(facet.out[1]), all_lanes(facet.out[2])},
        edge{all_lanes(static_cast<float>(facet.edge[0])), all_lanes(static_cast<float>(facet.edge[1])),
             all_lanes(static_cast<float>(facet.edge[2]))},
        radius(static_cast<float>(facet.radius)),
        size(static_cast<float>(length(facet.middle - origin) + 2.0 * facet.radius)) {}
};

/// What a ball that is `beside` a line has risen by over one round it, not more than that.
inline Lanes risen(Lanes beside, float radius) {
  beside = greater(beside, Lanes{});
  return where_no_more(all_lanes(radius), beside, all_lanes(kLaneFar), beside * beside * (0.5f / radius));
}

/// Of four sheets foot + a way + b core (a, b in 0..1) all that is within `radius` + `wide`.
struct FourSheets {
  LaneVec3 foot{}, way{}, core{};
  Lanes wide{};
  float radius = 0.0f, size = 0.0f;
  Lanes per_ww{}, per_aa{}, wa{};

  void set(int lane, Point<Part> origin, Point<Part> the_foot, Vec3 the_way, Vec3 the_core, double the_wide,
           double ball) {
    const Vec3 from = the_foot - origin;
    const auto put = [&](LaneVec3& to, Vec3 v) {
      to.x[lane] = static_cast<float>(v.x), to.y[lane] = static_cast<float>(v.y),
      to.z[lane] = static_cast<float>(v.z);
    };
    put(foot, from), put(way, the_way), put(core, the_core);
    const double ww = squared_length(the_way), aa = squared_length(the_core);
    const auto inverse = [](double v) { return v > kTiny ? static_cast<float>(1.0 / v) : 0.0f; };
    per_ww[lane] = inverse(ww), per_aa[lane] = inverse(aa);
    wa[lane] = static_cast<float>(dot(the_way, the_core));
    wide[lane] = static_cast<float>(the_wide), radius = static_cast<float>(ball);
    size = std::max(size,
                    static_cast<float>(length(from) + length(the_way) + length(the_core) + the_wide + ball));
  }
  float slack(const FacetLanes& f) const { return kLaneSlack * (size + f.size); }

  /// The least of direction . (p - place) over the sheet.
  Lanes lowest(LaneVec3 direction, LaneVec3 place) const {
    return dot(direction, foot - place) + lesser(Lanes{}, dot(direction, way)) +
           lesser(Lanes{}, dot(direction, core));
  }
  /// Over the facet's plane, mm: of all that the bodies sweep.
  Lanes over(const FacetLanes& f) const { return lowest(f.normal, f.middle) - wide - (radius + slack(f)); }
  /// Beyond its edges, along the plane.
  Lanes beyond(const FacetLanes& f) const {
    const Lanes most =
        greater(greater(lowest(f.out[0], f.middle) - f.edge[0], lowest(f.out[1], f.middle) - f.edge[1]),
                lowest(f.out[2], f.middle) - f.edge[2]);
    return most - wide - slack(f);
  }
  /// The way as it is seen along a facet's normal.
  struct Trace {
    LaneVec3 along;
    Lanes per_square;
  };
  Trace trace(const FacetLanes& f) const {
    const LaneVec3 along = flat(f, way);
    return {along, 1.0f / greater(squared_length(along), all_lanes(kTiny))};
  }
  /// Along the plane from a place, by the plane through the nearest point of the way: of sheets without core.
  Lanes beside(const FacetLanes& f, const Trace& t, LaneVec3 place) const {
    const LaneVec3 from = foot - place;
    const LaneVec3 u = flat(f, from) + t.along * clamped(-dot(from, t.along) * t.per_square);
    const LaneVec3 towards = flat(f, u * inverse_length(u));
    return dot(towards, from) + lesser(Lanes{}, dot(towards, way)) - wide - slack(f);
  }
  /// What may be left on lines along the normal within `round` of a place.
  struct Left {
    Lanes gap;    ///< not more than the way from the bodies to the lines' feet, mm
    Lanes least;  ///< not more than what is left there; -kLaneFar where the bodies may be met at the feet
  };
  Left left(const FacetLanes& f, LaneVec3 place, float round) const {
    const LaneVec3 from = apart(place);
    const Lanes gap = lowest(from, place) - wide - (radius + round + slack(f));
    const Lanes towards = dot(from, f.normal) + kSineSlack;
    const Lanes least = where_no_more(towards, Lanes{}, all_lanes(kLaneFar), gap / towards - slack(f));
    return {gap, where_no_more(gap, Lanes{}, all_lanes(-kLaneFar), least)};
  }
  /// Not more than the distance of the bodies from a box.
  Lanes distance(Vec3 middle, Vec3 half) const {
    const LaneVec3 place = all_lanes(middle), from = apart(place);
    const auto off = [](Lanes v, double by) { return greater(v, -v) * static_cast<float>(by); };
    const double its_size = length(middle) + length(half);
    return lowest(from, place) - off(from.x, half.x) - off(from.y, half.y) - off(from.z, half.z) - wide -
           (radius + kLaneSlack * (size + static_cast<float>(its_size)));
  }

 private:
  static constexpr float kTiny = 1e-12f;         // a squared length that is none
  static constexpr float kSineSlack = 0x1p-20f;  // more than rounding takes from a sine
  /// Unit, from a place to its nearest points of the sheets, or almost: each of them is behind the plane
  /// through its point nearest to the place, square to the way there.
  LaneVec3 apart(LaneVec3 place) const {
    const LaneVec3 m = place - foot;
    const Lanes mw = dot(m, way), ma = dot(m, core);
    const Lanes a = clamped((mw - clamped(ma * per_aa) * wa) * per_ww), b = clamped((ma - a * wa) * per_aa);
    const LaneVec3 u = m - way * a - core * b;
    return u * -inverse_length(u);
  }
  static LaneVec3 flat(const FacetLanes& f, LaneVec3 v) { return v - f.normal * dot(f.normal, v); }
  static Lanes clamped(Lanes v) { return greater(lesser(v, all_lanes(1.0f)), Lanes{}); }
  static Lanes inverse_length(LaneVec3 v) {
    return 1.0f / root(greater(squared_length(v), all_lanes(kTiny)));
  }
};

}  // namespace tiltfeed::sim
