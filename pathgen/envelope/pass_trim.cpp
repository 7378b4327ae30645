#include "pathgen/envelope/pass_trim.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

using Wanted = std::function<bool(const EnvelopePoint&)>;

/// A point of the straight move from a to b. Patches of shank and holder come after those of the cutting
/// part: where they have an end of the move, the cutting part need not touch between.
EnvelopePoint between(const Deformation& map, const EnvelopePoint& a, const EnvelopePoint& b, double f) {
  EnvelopePoint p = f < 0.5 ? a : b;
  p.patch = std::max(a.patch, b.patch);
  p.centre = lerp(a.centre, b.centre, f);
  p.flat = map.beside(map.flatten(p.centre), a.flat);
  p.axis = normalized(a.axis + (b.axis - a.axis) * f);
  const Vec3 normal = a.normal + (b.normal - a.normal) * f;
  if (length(normal) > 0.0) p.normal = normalized(normal);
  return p;
}

/// Shares of the pass's length, in mm along it, from `from` to `to`.
struct Piece {
  double from = 0.0, to = 0.0;
};

/// A pass by its length, mm.
class Measured {
 public:
  Measured(const Pass& pass, const Deformation& map) : pass_(pass), map_(map), run_(pass.size(), 0.0) {
    for (std::size_t i = 1; i < pass.size(); ++i)
      run_[i] = run_[i - 1] + distance(pass[i - 1].centre, pass[i].centre);
  }
  double run(std::size_t i) const { return run_[i]; }
  double length() const { return run_.back(); }
  Pass cut(Piece piece) const {
    Pass part;
    if (!(piece.to > piece.from)) return part;
    part.push_back(at(piece.from));
    for (std::size_t i = 0; i < pass_.size(); ++i)
      if (run_[i] > piece.from && run_[i] < piece.to) part.push_back(pass_[i]);
    part.push_back(at(piece.to));
    return part;
  }

 private:
  EnvelopePoint at(double run) const {
    const auto next = std::lower_bound(run_.begin(), run_.end(), run);
    const auto k =
        static_cast<std::size_t>(std::min<std::ptrdiff_t>(next - run_.begin(), std::ssize(run_) - 1));
    if (k == 0 || run_[k] == run) return pass_[k];
    return between(map_, pass_[k - 1], pass_[k], (run - run_[k - 1]) / (run_[k] - run_[k - 1]));
  }
  const Pass& pass_;
  const Deformation& map_;
  std::vector<double> run_;
};

/// Where on the pass `wanted` holds, in mm along it.
std::vector<Piece> wanted_pieces(const Pass& pass, const Deformation& map, const Measured& measured,
                                 const Wanted& wanted) {
  std::vector<Piece> pieces;
  bool on = wanted(pass.front());
  if (on) pieces.push_back({0.0, 0.0});
  for (std::size_t i = 1; i < pass.size(); ++i) {
    if (wanted(pass[i]) == on) continue;
    double same = 0.0, other = 1.0;
    const double step = measured.run(i) - measured.run(i - 1);
    while ((other - same) * step > kTrimStep) {
      const double f = (same + other) / 2.0;
      (wanted(between(map, pass[i - 1], pass[i], f)) == on ? same : other) = f;
    }
    const double at = measured.run(i - 1) + step * (on ? same : other);
    if (on) pieces.back().to = at;
    if (!on) pieces.push_back({at, at});
    on = !on;
  }
  if (on) pieces.back().to = measured.length();
  return pieces;
}

void keep(const Pass& pass, const Deformation& map, const Wanted& wanted, double overlap,
          std::vector<Pass>& kept) {
  const Measured measured(pass, map);
  std::vector<Piece> joined;
  for (Piece piece : wanted_pieces(pass, map, measured, wanted)) {
    piece.from = std::max(0.0, piece.from - overlap);
    piece.to = std::min(measured.length(), piece.to + overlap);
    if (!joined.empty() && piece.from <= joined.back().to) {
      joined.back().to = std::max(joined.back().to, piece.to);
    } else {
      joined.push_back(piece);
    }
  }
  for (const Piece& piece : joined)
    if (Pass part = measured.cut(piece); part.size() > 1) kept.push_back(std::move(part));
}

/// Turns a closed pass round to start at a point that is not wanted, if there is one.
void start_outside(Pass& pass, const Wanted& wanted) {
  const auto unwanted = std::find_if_not(pass.begin(), pass.end(), wanted);
  if (unwanted == pass.end()) return;
  const auto at = unwanted - pass.begin();
  pass.pop_back();
  std::rotate(pass.begin(), pass.begin() + at % std::ssize(pass), pass.end());
  pass.push_back(pass.front());
}

/// Shares of the way from a to b, rising, at which it crosses the polygon's border.
std::vector<double> border_crossings(const FlatPolygon& polygon, Point<Flat> a, Point<Flat> b) {
  std::vector<double> shares;
  const double dx = b.x - a.x, dy = b.y - a.y;
  for (std::size_t i = 0, last = polygon.size() - 1; i < polygon.size(); last = i++) {
    const double ex = polygon[i][0] - polygon[last][0], ey = polygon[i][1] - polygon[last][1];
    const double det = dx * ey - dy * ex;
    if (det == 0.0) continue;
    const double wx = polygon[last][0] - a.x, wy = polygon[last][1] - a.y;
    const double f = (wx * ey - wy * ex) / det, g = (wx * dy - wy * dx) / det;
    if (f > 0.0 && f < 1.0 && g >= 0.0 && g <= 1.0) shares.push_back(f);
  }
  std::sort(shares.begin(), shares.end());
  return shares;
}

/// The pass with points where it crosses the polygon's border, in pairs just on either side of it.
Pass with_crossings(const Pass& pass, const Deformation& map, const FlatPolygon& polygon) {
  Pass dense;
  for (std::size_t i = 0; i < pass.size(); ++i) {
    if (i > 0) {
      const double size = distance(pass[i - 1].centre, pass[i].centre);
      const Point<Flat> a = pass[i - 1].flat, next = map.beside(pass[i].flat, a);
      for (double f : border_crossings(polygon, a, next))
        for (double side : {-kTrimStep, kTrimStep})
          if (const double at = f + side / size; at > 0.0 && at < 1.0)
            dense.push_back(between(map, pass[i - 1], pass[i], at));
    }
    dense.push_back(pass[i]);
  }
  return dense;
}

}  // namespace

bool in_polygon(const FlatPolygon& polygon, double x, double y) {
  if (polygon.empty()) return true;
  bool in = false;
  for (std::size_t i = 0, last = polygon.size() - 1; i < polygon.size(); last = i++) {
    const auto &a = polygon[i], &b = polygon[last];
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])) in = !in;
  }
  return in;
}

std::vector<Pass> keep_where(const std::vector<Pass>& passes, const Deformation& map,
                             const std::function<bool(const EnvelopePoint&)>& wanted, double overlap) {
  std::vector<Pass> kept;
  for (const Pass& pass : passes) {
    if (pass.empty()) continue;
    Pass turned = pass;
    if (is_closed(turned)) start_outside(turned, wanted);
    keep(turned, map, wanted, overlap, kept);
  }
  return kept;
}

std::vector<Pass> inside_polygon(const std::vector<Pass>& passes, const Deformation& map,
                                 const FlatPolygon& polygon) {
  if (polygon.empty()) return passes;
  std::vector<Pass> dense;
  for (const Pass& pass : passes) dense.push_back(with_crossings(pass, map, polygon));
  return keep_where(
      dense, map, [&](const EnvelopePoint& p) { return in_polygon(polygon, p.flat.x, p.flat.y); }, 0.0);
}

double slope(const EnvelopePoint& point) { return angle_between(point.normal, point.axis); }

std::vector<Pass> steep_of(const std::vector<Pass>& passes, const Deformation& map, Angle split_slope,
                           double overlap) {
  return keep_where(
      passes, map, [&](const EnvelopePoint& p) { return slope(p) >= split_slope.radians(); }, overlap);
}

std::vector<Pass> shallow_of(const std::vector<Pass>& passes, const Deformation& map, Angle split_slope,
                             double overlap) {
  return keep_where(
      passes, map, [&](const EnvelopePoint& p) { return slope(p) < split_slope.radians(); }, overlap);
}

bool is_closed(const Pass& pass) { return pass.size() > 2 && pass.front().centre == pass.back().centre; }

void start_near(Pass& pass, Point<Part> to) {
  if (!is_closed(pass)) return;
  pass.pop_back();
  const auto nearest = std::min_element(pass.begin(), pass.end(), [&](const auto& a, const auto& b) {
    return distance(a.centre, to) < distance(b.centre, to);
  });
  std::rotate(pass.begin(), nearest, pass.end());
  pass.push_back(pass.front());
}

}  // namespace tiltfeed::pathgen
