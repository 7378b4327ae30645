#include "sim/solid/revolved.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace tiltfeed::sim {
namespace {

constexpr double kQuarter = kPi / 2.0;
// Angles of normals nearer than this, rad, are one: two rims on a line.
constexpr double kSameAngle = 1e-12;
// The search halves its interval at least every third step: far more steps than double precision has bits.
constexpr int kMostSteps = 200;
// Below this sine a facet lies square to the axis, and any plane through the axis is one of symmetry.
constexpr double kSquare = 1e-12;

double cross2(double ar, double ah, double br, double bh) { return ar * bh - ah * br; }

struct OnLine {
  double value, slope;
};

/// Least value of the convex f over [low, high], to kSearchError, or anything >= bound if it is not below.
/// The tangents at both ends bound it from below and meet where it is looked at next.
template <class F>
double least_on(const F& f, double low, double high, double bound) {
  OnLine a = f(low), b = f(high);
  double best = std::min(a.value, b.value), last_width = high - low;
  if (a.slope >= 0.0 || b.slope <= 0.0) return best;
  for (int step = 0; step < kMostSteps; ++step) {
    double t = (b.value - a.value + a.slope * low - b.slope * high) / (a.slope - b.slope);
    if (t > low && t < high) {
      if (a.value + a.slope * (t - low) >= std::min(best, bound) - kSearchError) return best;
    } else {
      t = 0.5 * (low + high);
    }
    if (step % 3 == 2) {
      if (high - low > 0.5 * last_width) t = 0.5 * (low + high);
      last_width = high - low;
    }
    if (!(t > low && t < high)) return best;
    const OnLine c = f(t);
    best = std::min(best, c.value);
    if (c.slope == 0.0) return best;
    if (c.slope < 0.0)
      a = c, low = t;
    else
      b = c, high = t;
  }
  return best;
}

}  // namespace

Revolved::Revolved(const std::vector<Corner>& corners) : corners_(corners) {
  assert(!corners_.empty() && std::abs(corners_.back().turn - kPi) < kSameAngle);
  for (const Corner& c : corners_) sides_.push_back({std::sin(c.turn), -std::cos(c.turn)});
  for (const Corner& c : corners_) {
    if (c.turn < kQuarter - kSameAngle) continue;
    widest_ = c.r + c.radius, widest_height_ = c.h;
    break;
  }
}

Revolved Revolved::from_rims(const std::vector<std::array<double, 2>>& rims) {
  std::vector<Corner> corners;
  for (std::size_t i = 0; i < rims.size(); ++i) {
    double turn = kPi;
    if (i + 1 < rims.size()) {
      // The normal of the side (dr, dh) is (dh, -dr).
      turn = std::atan2(rims[i + 1][1] - rims[i][1], rims[i + 1][0] - rims[i][0]);
      assert(corners.empty() || turn > corners.back().turn - kSameAngle);
      if (!corners.empty() && turn < corners.back().turn + kSameAngle) continue;
    }
    corners.push_back({rims[i][0], rims[i][1], 0.0, turn});
  }
  return Revolved(corners);
}

Revolved Revolved::grown(double allowance, double radial, double axial) const {
  std::vector<Corner> more;
  double begin = 0.0;
  for (const Corner& c : corners_) {
    const Corner lower{c.r + radial, c.h - axial, c.radius + allowance, std::min(c.turn, kQuarter)};
    const Corner upper{c.r + radial, c.h, c.radius + allowance, c.turn};
    if (axial > 0.0 && begin < kQuarter) more.push_back(lower);
    if (axial == 0.0 || c.turn > kQuarter) more.push_back(upper);
    begin = c.turn;
  }
  return Revolved(more);
}

Slope Revolved::distance(double r, double h) const {
  // The largest of q.u - support(u) over all unit u: sides where u is a side's normal, arcs where u points
  // from an arc's centre to q.
  const Corner& lowest = corners_.front();
  Slope most{lowest.h - lowest.radius - h, 0.0, -1.0};
  Side begin{0.0, -1.0};
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Corner& c = corners_[i];
    const Side& end = sides_[i];
    const double dr = r - c.r, dh = h - c.h;
    if (cross2(begin.sine, begin.cosine, dr, dh) > 0.0 && cross2(dr, dh, end.sine, end.cosine) > 0.0) {
      const double far = std::sqrt(dr * dr + dh * dh);
      if (far - c.radius > most.value) most = {far - c.radius, dr / far, dh / far};
    }
    const double over = dr * end.sine + dh * end.cosine - c.radius;
    if (over > most.value) most = {over, end.sine, end.cosine};
    begin = end;
  }
  return most;
}

Slope Revolved::lower_border(double r) const {
  const Corner& lowest = corners_.front();
  if (r <= lowest.r) return {lowest.h - lowest.radius, 0.0, 0.0};
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Corner& c = corners_[i];
    const Side& side = sides_[i];
    const bool is_last = c.turn >= kQuarter - kSameAngle;
    const double end = is_last ? widest_ : c.r + c.radius * side.sine;
    if (r <= end && c.radius > 0.0) {
      const double across = r - c.r, up = std::sqrt(std::max(0.0, c.radius * c.radius - across * across));
      return {c.h - up, up > 0.0 ? across / up : kInfinity, 0.0};
    }
    if (is_last) return r <= end ? Slope{c.h, kInfinity, 0.0} : Slope{kInfinity, kInfinity, 0.0};
    const Corner& next = corners_[i + 1];
    const double slope = -side.sine / side.cosine;
    if (r <= next.r + next.radius * side.sine)
      return {c.h + c.radius * side.cosine + (r - end) * slope, slope, 0.0};
  }
  return {kInfinity, kInfinity, 0.0};
}

double Revolved::radius_at(double h) const {
  if (distance(0.0, h).value > 0.0) return -1.0;
  // Half the section's width, by the same convex search as everything else: where the distance leaves 0.
  double in = 0.0, out = widest_;
  if (distance(out, h).value <= 0.0) return out;
  while (out - in > kSearchError) {
    const double middle = 0.5 * (in + out);
    (distance(middle, h).value <= 0.0 ? in : out) = middle;
  }
  return in;
}

Standing::At Standing::at(Vec3 from_tip) const {
  const double h = dot(from_tip, axis_);
  const Vec3 across = from_tip - axis_ * h;
  const double r = length(across);
  return {r, h, r > 0.0 ? across / r : Vec3{}};
}

double Standing::distance_bound(Vec3 low, Vec3 high) const {
  const Vec3 half = (high - low) * 0.5;
  const At centre = at((low + high) * 0.5 - from_origin(tip_));
  const Slope s = solid_->distance(centre.r, centre.h);
  const Vec3 u = centre.out * s.along_r + axis_ * s.along_h;
  return s.value - (std::abs(u.x) * half.x + std::abs(u.y) * half.y + std::abs(u.z) * half.z);
}

double Standing::drop_bound(Vec3 low, Vec3 high) const {
  const Vec3 half = (high - low) * 0.5;
  const auto reach = [&](Vec3 u) {
    return std::abs(u.x) * half.x + std::abs(u.y) * half.y + std::abs(u.z) * half.z;
  };
  const At centre = at((low + high) * 0.5 - from_origin(tip_));
  const double rise = reach(axis_);
  if (centre.h - rise > solid_->widest_height()) return kInfinity;
  const double nearest = std::max(0.0, centre.r - reach(centre.out));
  if (nearest > solid_->widest()) return kInfinity;
  double bound = solid_->lower_border(nearest).value - centre.h - rise;
  const Slope s = solid_->lower_border(centre.r);
  if (s.along_r < kInfinity)
    bound = std::max(bound, s.value - centre.h - reach(centre.out * s.along_r - axis_));
  return bound;
}

double Standing::least_distance(Vec3 from, Vec3 to, double bound) const {
  const Vec3 d = to - from;
  return least_on(
      [&](double t) -> OnLine {
        const At q = at(from + d * t);
        const Slope s = solid_->distance(q.r, q.h);
        return {s.value, s.along_r * dot(q.out, d) + s.along_h * dot(axis_, d)};
      },
      0.0, 1.0, bound);
}

double Standing::least_drop(Vec3 from, Vec3 to, double bound) const {
  const Vec3 d = to - from;
  const double h = dot(from, axis_), rise = dot(d, axis_);
  const Vec3 across = from - axis_ * h, run = d - axis_ * rise;
  // The part of the line that lies under the solid and not above its widest place.
  double low = 0.0, high = 1.0;
  const double above = h - solid_->widest_height();
  if (rise > 0.0) high = std::min(high, -above / rise);
  if (rise < 0.0) low = std::max(low, -above / rise);
  if (rise == 0.0 && above > 0.0) return bound;
  const double aa = squared_length(run), ab = dot(run, across);
  const double gap = squared_length(across) - solid_->widest() * solid_->widest();
  if (aa > 0.0) {
    const double root = ab * ab - aa * gap;
    if (root < 0.0) return bound;
    low = std::max(low, (-ab - std::sqrt(root)) / aa), high = std::min(high, (-ab + std::sqrt(root)) / aa);
  } else if (gap > 0.0) {
    return bound;
  }
  if (low > high) return bound;
  const double least = least_on(
      [&](double t) -> OnLine {
        const Vec3 q = across + run * t;
        // Rounding may put the ends of the line beyond the widest place.
        const double r = std::min(length(q), solid_->widest());
        const Slope s = solid_->lower_border(r);
        return {s.value - (h + rise * t), s.along_r * (r > 0.0 ? dot(q, run) / r : 0.0) - rise};
      },
      low, high, bound);
  return std::min(bound, std::max(0.0, least));
}

namespace {

/// (V7) The plane through the axis square to the facet is a plane of symmetry of solid and facet's plane: the
/// best point of that plane lies on it. If it is inside the triangle it is on this chord, else the triangle's
/// best point is on an edge. No chord: false.
bool symmetry_chord(const Triangle& t, Point<Part> tip, Vec3 axis, Vec3& from, Vec3& to) {
  if (t.normal == Vec3{}) return false;
  Vec3 k = cross(axis, t.normal);
  if (squared_length(k) < kSquare * kSquare)
    k = cross(axis, std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
  const Vec3 a = t.a - tip;
  const std::array<Vec3, 3> corner{a, a + t.ab, a + t.ac};
  std::array<double, 3> side{};
  for (int i = 0; i < 3; ++i) side[i] = dot(k, corner[i]);
  int ends = 0;
  for (int i = 0; i < 3 && ends < 2; ++i) {
    const int j = (i + 1) % 3;
    if ((side[i] < 0.0) == (side[j] < 0.0)) continue;
    (ends == 0 ? from : to) = corner[i] + (corner[j] - corner[i]) * (side[i] / (side[i] - side[j]));
    ++ends;
  }
  return ends == 2;
}

}  // namespace

double Standing::distance(const Triangle& t, double bound) const {
  const Vec3 a = t.a - tip_, b = a + t.ab, c = a + t.ac, centre = (a + b + c) / 3.0;
  const At q = at(centre);
  const Slope s = solid_->distance(q.r, q.h);
  const Vec3 u = q.out * s.along_r + axis_ * s.along_h;
  if (s.value + std::min({dot(u, a - centre), dot(u, b - centre), dot(u, c - centre)}) >= bound) return bound;
  Vec3 from, to;
  if (symmetry_chord(t, tip_, axis_, from, to)) bound = std::min(bound, least_distance(from, to, bound));
  if (t.owned & 1) bound = std::min(bound, least_distance(a, b, bound));
  if (t.owned & 2) bound = std::min(bound, least_distance(b, c, bound));
  if (t.owned & 4) bound = std::min(bound, least_distance(c, a, bound));
  return bound;
}

double Standing::drop(const Triangle& t, double bound) const {
  const Vec3 a = t.a - tip_, b = a + t.ab, c = a + t.ac, centre = (a + b + c) / 3.0;
  const At q = at(centre);
  const Slope s = solid_->lower_border(q.r);
  if (s.along_r < kInfinity) {
    const Vec3 u = q.out * s.along_r - axis_;
    const double least = std::min({dot(u, a - centre), dot(u, b - centre), dot(u, c - centre)});
    if (s.value - q.h + least >= bound) return bound;
  }
  Vec3 from, to;
  if (symmetry_chord(t, tip_, axis_, from, to)) bound = std::min(bound, least_drop(from, to, bound));
  if (t.owned & 1) bound = std::min(bound, least_drop(a, b, bound));
  if (t.owned & 2) bound = std::min(bound, least_drop(b, c, bound));
  if (t.owned & 4) bound = std::min(bound, least_drop(c, a, bound));
  return bound;
}

}  // namespace tiltfeed::sim
