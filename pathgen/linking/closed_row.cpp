#include "pathgen/linking/closed_row.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {
namespace {

/// Both ends of a closed row are the same place, to rounding (mm); of their axes the same (rad).
constexpr double kSamePlaceOfRow = 1e-6;
/// Fewer points make no ring.
constexpr std::size_t kFewestPoints = 4;

/// Where `p` is off the way from a to b the least: its share, 0 to 1.
double nearest_on(Point<Part> p, Point<Part> a, Point<Part> b) {
  const Vec3 way = b - a;
  const double length2 = squared_length(way);
  return length2 > 0.0 ? std::clamp(dot(p - a, way) / length2, 0.0, 1.0) : 0.0;
}

/// The row's points in the order of travel; the last is the first a turn on.
class Ring {
 public:
  Ring(const Pass& row, bool reversed) : row_(row), reversed_(reversed) {
    const Vec3 turn = row.back().flat - row.front().flat;
    turn_ = reversed ? turn * -1.0 : turn;
  }
  std::size_t size() const { return row_.size() - 1; }
  EnvelopePoint at(std::size_t i) const {
    const std::size_t k = i % size();
    EnvelopePoint p = reversed_ ? row_[size() - k] : row_[k];
    if (i >= size()) p.flat = p.flat + turn_;
    return p;
  }

 private:
  const Pass& row_;
  bool reversed_;
  Vec3 turn_;
};

}  // namespace

bool goes_round(const Pass& row) {
  if (row.size() < kFewestPoints) return false;
  const EnvelopePoint &a = row.front(), &b = row.back();
  return distance(a.centre, b.centre) <= kSamePlaceOfRow && length(a.axis - b.axis) <= kSamePlaceOfRow &&
         std::hypot(b.flat.x - a.flat.x, b.flat.y - a.flat.y) > kSamePlaceOfRow;
}

Pass begun_near(const Pass& row, bool reversed, Point<Part> from) {
  const Ring ring(row, reversed);
  std::size_t nearest = 0;
  double off = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point<Part> a = ring.at(i).centre, b = ring.at(i + 1).centre;
    const double d = distance(from, a + (b - a) * nearest_on(from, a, b));
    if (d < off) off = d, nearest = i;
  }
  const std::size_t begin = (nearest + 1) % ring.size();
  Pass out;
  out.reserve(row.size());
  for (std::size_t i = begin; i <= begin + ring.size(); ++i) out.push_back(ring.at(i));
  return out;
}

}  // namespace tiltfeed::pathgen
