#include "pathgen/pattern/spiral.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tiltfeed::pathgen {

namespace {

/// Longest distance of two places of a ring from which the way to the next is laid, in side steps.
constexpr double kDenseShare = 0.2;
/// The furthest from a ring to the next, in side steps: at the corners of an acute angle (47 degrees).
constexpr double kFurthest = 2.5;
/// A turn along a ring that comes out shorter than the ring by more than this (share) has gone wrong.
constexpr double kLostTurn = 1e-6;

/// A place of a ring; `turn`: how much of the turn lies behind, 0 to 1.
struct Mark {
  Place place;
  double turn = 0.0;
};

/// A closed curve by its length.
class Track {
 public:
  explicit Track(const FlatCurve& curve) : curve_(curve), run_(curve.size(), 0.0) {
    for (std::size_t i = 1; i < curve.size(); ++i) run_[i] = run_[i - 1] + distance(curve[i - 1], curve[i]);
  }
  double length() const { return run_.back(); }

  Place at(double run) const {
    run = std::fmod(run, length());
    const auto next = std::upper_bound(run_.begin(), run_.end(), run);
    const auto k = std::clamp<std::ptrdiff_t>(next - run_.begin(), 1, std::ssize(run_) - 1);
    const auto i = static_cast<std::size_t>(k);
    const double size = run_[i] - run_[i - 1];
    return size > 0.0 ? lerp(curve_[i - 1], curve_[i], (run - run_[i - 1]) / size) : curve_[i];
  }

  /// Run of the place nearest to p.
  double nearest(Place p) const {
    double best = kShut, run = 0.0;
    for (std::size_t i = 1; i < curve_.size(); ++i) {
      const Place a = curve_[i - 1], b = curve_[i];
      const double ux = b.x - a.x, uy = b.y - a.y, ll = ux * ux + uy * uy;
      const double f = ll > 0.0 ? std::clamp(((p.x - a.x) * ux + (p.y - a.y) * uy) / ll, 0.0, 1.0) : 0.0;
      const double off = distance(p, lerp(a, b, f));
      if (off < best) best = off, run = run_[i - 1] + (run_[i] - run_[i - 1]) * f;
    }
    return run;
  }

  /// Marks from `from` to `to` (excluded) at its corners and densely between, their turns shared out evenly.
  void mark(double from, double to, double turn_from, double turn_to, double dense,
            std::vector<Mark>& marks) const {
    std::vector<double> runs{from};
    for (double base : {0.0, length()})
      for (double r : run_)
        if (r + base > from && r + base < to) runs.push_back(r + base);
    runs.push_back(to);
    for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
      const double pieces = std::max(1.0, std::ceil((runs[i + 1] - runs[i]) / dense));
      for (double k = 0.0; k < pieces; ++k) {
        const double run = runs[i] + (runs[i + 1] - runs[i]) * k / pieces;
        const double share = to > from ? (run - from) / (to - from) : 0.0;
        marks.push_back({at(run), turn_from + (turn_to - turn_from) * share});
      }
    }
  }

 private:
  const FlatCurve& curve_;
  std::vector<double> run_;
};

/// Runs on the inner track of the places nearest to the marks, never going back; nothing where that is not
/// one turn, or too far away.
std::optional<std::vector<double>> feet(const std::vector<Mark>& marks, const Track& inner, double furthest) {
  std::vector<double> runs;
  for (const Mark& mark : marks) {
    const double run = inner.nearest(mark.place);
    if (distance(inner.at(run), mark.place) > furthest) return std::nullopt;
    if (runs.empty()) {
      runs.push_back(run);
      continue;
    }
    const double ahead = std::remainder(run - runs.back(), inner.length());
    runs.push_back(runs.back() + std::max(0.0, ahead));
  }
  const double rest = runs.front() + inner.length() - runs.back();
  if (rest < -kLostTurn * inner.length()) return std::nullopt;
  return runs;
}

FlatCurve whole(const std::vector<Mark>& marks) {
  FlatCurve curve;
  for (const Mark& mark : marks) curve.push_back(mark.place);
  curve.push_back(curve.front());
  return curve;
}

}  // namespace

std::vector<FlatCurve> spirals_through(const std::vector<FlatCurve>& rings, double side_step) {
  std::vector<FlatCurve> spirals;
  const double dense = kDenseShare * side_step;
  std::vector<Mark> marks;
  for (std::size_t k = 0; k < rings.size(); ++k) {
    const Track track(rings[k]);
    if (spirals.empty() || marks.empty()) {
      track.mark(0.0, track.length(), 0.0, 1.0, dense, marks);
      spirals.push_back(whole(marks));
    }
    if (k + 1 == rings.size()) break;
    const Track inner(rings[k + 1]);
    const auto runs = feet(marks, inner, kFurthest * side_step);
    if (!runs) {  // the spiral ends on this ring
      if (spirals.back().size() > marks.size() + 1)
        for (Place p : whole(marks)) spirals.back().push_back(p);
      marks.clear();
      continue;
    }
    for (std::size_t i = 0; i < marks.size(); ++i)
      spirals.back().push_back(lerp(marks[i].place, inner.at((*runs)[i]), marks[i].turn));
    std::vector<Mark> next;
    for (std::size_t i = 0; i < marks.size(); ++i) {
      const bool last = i + 1 == marks.size();
      const double to = last ? runs->front() + inner.length() : (*runs)[i + 1];
      inner.mark((*runs)[i], to, marks[i].turn, last ? 1.0 : marks[i + 1].turn, dense, next);
    }
    marks = std::move(next);
    if (k + 2 == rings.size())
      for (Place p : whole(marks)) spirals.back().push_back(p);
  }
  return spirals;
}

}  // namespace tiltfeed::pathgen
