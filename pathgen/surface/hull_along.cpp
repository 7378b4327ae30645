#include "pathgen/surface/hull_along.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {

HullAlong::HullAlong(const FlatHull& hull, const FlatCorner* corner, double dx, double dy, double shift_x,
                     double shift_y)
    : count_(hull.count), patch_(hull.patch), top_(hull.top) {
  const double ax = std::abs(dx), ay = std::abs(dy);
  cross_pad_ = ay * hull.pad_x + ax * hull.pad_y, run_pad_ = ax * hull.pad_x + ay * hull.pad_y;
  const auto put = [&](std::uint32_t i, double x, double y) {
    x += shift_x, y += shift_y;
    place_[i] = {y * dx - x * dy, x * dx + y * dy};
  };
  if (count_ == 2) {
    count_ = 4;
    put(0, corner[0].x, corner[0].y), put(1, corner[1].x, corner[0].y);
    put(2, corner[1].x, corner[1].y), put(3, corner[0].x, corner[1].y);
  } else {
    for (std::uint32_t i = 0; i < count_; ++i) put(i, corner[i].x, corner[i].y);
  }
  least_ = most_ = place_[0].across;
  for (std::uint32_t i = 1; i < count_; ++i)
    least_ = std::min(least_, place_[i].across), most_ = std::max(most_, place_[i].across);
}

bool HullAlong::meets(const FlatLine& line, Candidate& candidate) const {
  const double across = line.across(), low = across - cross_pad_, high = across + cross_pad_;
  if (least_ > high || most_ < low) return false;
  double from = std::numeric_limits<double>::infinity(), to = -from;
  const auto add = [&](double run) { from = std::min(from, run), to = std::max(to, run); };
  for (std::uint32_t i = 0; i < count_; ++i)
    if (place_[i].across >= low && place_[i].across <= high) add(place_[i].run);
  const auto cut = [&](double border) {
    if (least_ >= border || most_ < border) return;
    for (std::uint32_t i = 0; i < count_; ++i)
      for (std::uint32_t j = i + 1; j < count_; ++j) {
        const Place &p = place_[i], &q = place_[j];
        if ((p.across < border) == (q.across < border)) continue;
        add(p.run + (q.run - p.run) * ((border - p.across) / (q.across - p.across)));
      }
  };
  cut(low), cut(high);
  const double start = line.x * line.dx + line.y * line.dy;
  from -= run_pad_ + start, to += run_pad_ - start;
  if (from > to || to < 0.0 || from > line.length) return false;
  candidate = {std::max(from, 0.0), std::min(to, line.length), patch_, top_};
  return true;
}

}  // namespace tiltfeed::pathgen
