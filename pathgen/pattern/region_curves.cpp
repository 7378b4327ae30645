#include "pathgen/pattern/region_curves.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pathgen/pattern/spiral.h"

namespace tiltfeed::pathgen {

namespace {

/// What lies further than this from the next ring (side steps) gets a curve of its own: more than a right
/// angle's corner does, less than an arm or a neck that has no next ring.
constexpr double kFarFromNext = 0.75;
/// Steps in which such curves are looked for, and how closely their ends are found, in side steps.
constexpr double kLookStep = 0.125, kEndShare = 1e-3;

/// A ring, the rings right inside it, and curves that fill what the step to them leaves out.
struct Ring {
  FlatRegion region;
  std::vector<std::size_t> inner;
  std::vector<FlatCurve> fillers;
};

FlatCurve curve_of(const FlatPolygon& polygon, bool reversed) {
  FlatCurve curve;
  for (const auto& p : polygon) curve.push_back({p[0], p[1]});
  if (reversed) std::reverse(curve.begin(), curve.end());
  curve.push_back(curve.front());
  return curve;
}

bool holds(const FlatRegion& outer, const FlatRegion& inner) {
  return in_region(outer, inner.border[0][0], inner.border[0][1]);
}

double distance_from(const FlatPolygon& polygon, Place p) {
  double least = kShut;
  for (std::size_t i = 0, last = polygon.size() - 1; i < polygon.size(); last = i++) {
    const Point<Flat> a{polygon[last][0], polygon[last][1], 0.0}, b{polygon[i][0], polygon[i][1], 0.0};
    least = std::min(least, distance_to_segment(Point<Flat>{p.x, p.y, 0.0}, a, b));
  }
  return least;
}

/// The pieces of a closed curve that lie further than half a step from the regions, if any of it is further
/// than kFarFromNext.
std::vector<FlatCurve> far_pieces(const FlatCurve& closed, const std::vector<FlatRegion>& regions,
                                  double step) {
  const auto off = [&](Place p) {
    double least = kShut;
    for (const FlatRegion& region : regions) {
      least = std::min(least, distance_from(region.border, p));
      for (const FlatPolygon& hole : region.holes) least = std::min(least, distance_from(hole, p));
    }
    return least - step / 2.0;
  };
  FlatCurve dense;
  for (std::size_t i = 0; i + 1 < closed.size(); ++i) {
    const double count = std::max(1.0, std::ceil(distance(closed[i], closed[i + 1]) / (kLookStep * step)));
    for (double k = 0.0; k < count; ++k) dense.push_back(lerp(closed[i], closed[i + 1], k / count));
  }
  std::vector<double> over;
  for (const Place& p : dense) over.push_back(off(p));
  const auto near = std::find_if(over.begin(), over.end(), [](double v) { return v <= 0.0; }) - over.begin();
  std::vector<FlatCurve> pieces;
  if (near == std::ssize(over)) return pieces;
  const auto end_between = [&](Place inside, Place outside) {
    while (distance(inside, outside) > kEndShare * step) {
      const Place middle = lerp(inside, outside, 0.5);
      (off(middle) > 0.0 ? outside : inside) = middle;
    }
    return outside;
  };
  FlatCurve piece;
  double furthest = 0.0;
  for (std::size_t k = 0; k < dense.size(); ++k) {
    const std::size_t here = (static_cast<std::size_t>(near) + k) % dense.size(),
                      next = (here + 1) % dense.size();
    if (over[here] > 0.0) piece.push_back(dense[here]), furthest = std::max(furthest, over[here]);
    if ((over[here] > 0.0) == (over[next] > 0.0)) continue;
    if (over[next] > 0.0) {
      piece = {end_between(dense[here], dense[next])};
      furthest = 0.0;
      continue;
    }
    piece.push_back(end_between(dense[next], dense[here]));
    if (furthest > (kFarFromNext - 0.5) * step) pieces.push_back(std::move(piece));
    piece.clear();
  }
  return pieces;
}

/// All rings of the regions as a forest: `roots` and each ring's `inner`.
class Rings {
 public:
  Rings(const std::vector<FlatRegion>& regions, const CurveOptions& options) {
    const double step = options.side_step;
    std::vector<std::size_t> last = add(moved_inwards(regions, step / 2.0, options.tolerance), nullptr);
    roots_ = last;
    for (double k = 1.0; !last.empty(); ++k) {
      const std::vector<FlatRegion> next = moved_inwards(regions, step * (k + 0.5), options.tolerance);
      std::vector<FlatRegion> ends;
      for (FlatRegion& core : moved_inwards(regions, step * k, options.tolerance)) {
        std::vector<FlatRegion> inside;
        for (const FlatRegion& r : next)
          if (holds(core, r)) inside.push_back(r);
        if (!inside.empty()) fill(core, inside, last, options);
        if (inside.empty()) ends.push_back(std::move(core));
      }
      add(ends, &last);
      last = add(next, &last);
    }
  }
  std::vector<Ring> rings;
  const std::vector<std::size_t>& roots() const { return roots_; }

 private:
  /// Curves for what of the core the next rings leave out, with the ring round it.
  void fill(const FlatRegion& core, const std::vector<FlatRegion>& next,
            const std::vector<std::size_t>& outer, const CurveOptions& options) {
    const auto round =
        std::find_if(outer.begin(), outer.end(), [&](std::size_t o) { return holds(rings[o].region, core); });
    if (round == outer.end()) return;
    const auto add_pieces = [&](const FlatPolygon& polygon) {
      for (FlatCurve& piece : far_pieces(curve_of(polygon, options.clockwise), next, options.side_step))
        rings[*round].fillers.push_back(std::move(piece));
    };
    add_pieces(core.border);
    for (const FlatPolygon& hole : core.holes) add_pieces(hole);
  }
  std::vector<std::size_t> add(const std::vector<FlatRegion>& regions,
                               const std::vector<std::size_t>* outer) {
    std::vector<std::size_t> added;
    for (const FlatRegion& region : regions) {
      const std::size_t id = rings.size();
      if (outer != nullptr)
        for (std::size_t o : *outer)
          if (holds(rings[o].region, region)) {
            rings[o].inner.push_back(id);
            break;
          }
      rings.push_back({region, {}, {}});
      added.push_back(id);
    }
    return added;
  }
  std::vector<std::size_t> roots_;
};

class Curves {
 public:
  Curves(const Rings& rings, const CurveOptions& options) : rings_(rings), options_(options) {}

  RegionCurves run() {
    std::vector<std::size_t> waiting(rings_.roots().rbegin(), rings_.roots().rend());
    while (!waiting.empty()) {
      std::size_t id = waiting.back();
      waiting.pop_back();
      std::vector<std::size_t> chain{id};
      while (!rings_.rings[id].inner.empty()) {
        const auto& inner = rings_.rings[id].inner;
        waiting.insert(waiting.end(), inner.rbegin(), inner.rend() - 1);
        chain.push_back(id = inner.front());
      }
      std::vector<FlatCurve> group;
      options_.spiral ? spirals(chain, group) : loops(chain, group);
      result_.groups.push_back(std::move(group));
    }
    return std::move(result_);
  }

 private:
  void loops(const std::vector<std::size_t>& chain, std::vector<FlatCurve>& group) const {
    for (std::size_t id : chain) {
      const FlatRegion& region = rings_.rings[id].region;
      group.push_back(curve_of(region.border, options_.clockwise));
      for (const FlatPolygon& hole : region.holes) group.push_back(curve_of(hole, options_.clockwise));
      add_fillers(id, group);
    }
  }
  void add_fillers(std::size_t id, std::vector<FlatCurve>& group) const {
    const auto& fillers = rings_.rings[id].fillers;
    group.insert(group.end(), fillers.begin(), fillers.end());
  }

  /// A spiral for each run of rings without holes that lie one in the other; one by one where there are more.
  void spirals(const std::vector<std::size_t>& chain, std::vector<FlatCurve>& group) {
    for (std::size_t k = 0; k < chain.size();) {
      if (!rings_.rings[chain[k]].region.holes.empty()) {
        const std::size_t before = group.size();
        loops({chain[k++]}, group);
        result_.loops_in_spiral += group.size() - before;
        continue;
      }
      std::vector<FlatCurve> run;
      const std::size_t first = k;
      for (; k < chain.size() && rings_.rings[chain[k]].region.holes.empty(); ++k) {
        run.push_back(curve_of(rings_.rings[chain[k]].region.border, options_.clockwise));
        if (rings_.rings[chain[k]].inner.size() > 1) {
          ++k;
          break;
        }
      }
      for (FlatCurve& curve : spirals_through(run, options_.side_step)) group.push_back(std::move(curve));
      for (std::size_t i = first; i < k; ++i) add_fillers(chain[i], group);
    }
  }

  const Rings& rings_;
  const CurveOptions& options_;
  RegionCurves result_;
};

}  // namespace

Result<RegionCurves> region_curves(const std::vector<FlatRegion>& regions, const CurveOptions& options) {
  if (!(options.side_step > 0.0)) return fail(Code::kInput, "pattern.side_step_mm must be a positive length");
  double widest = 0.0;
  for (const FlatRegion& region : regions) {
    double low = kShut, high = kNoSurface;
    for (const auto& p : region.border) low = std::min(low, p[0]), high = std::max(high, p[0]);
    widest = std::max(widest, high - low);
  }
  if (widest / options.side_step > 2.0 * kMaxRings)
    return fail(Code::kLimit, "pattern.side_step_mm of " + std::to_string(options.side_step) +
                                  " asks for more than " + std::to_string(static_cast<int>(kMaxRings)) +
                                  " rings over " + std::to_string(widest) + " mm; use a larger step");
  return Curves(Rings(regions, options), options).run();
}

}  // namespace tiltfeed::pathgen
