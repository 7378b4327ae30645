// The choice of Stations: the cheapest sequence of admissible directions.

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "pathgen/free_axis/stations.h"

namespace tiltfeed::pathgen {

namespace {

/// A break costs as much as a departure of one radian over this length, mm.
constexpr double kJumpLength = 40.0;
/// So often only candidates that a sequence would want next are asked; then all of a station.
constexpr int kFewRounds = 6;
/// So often directions are looked at further from the wish.
constexpr int kFurther = 5;

}  // namespace

/// Is the candidate admissible?
bool Stations::holds(Station& s, AxisCandidate& candidate) {
  if (candidate.clear) return true;
  if (candidate.direction == kNoDirection)
    return candidate.clear = admissible_.admits(s.point, candidate.axis, query_);
  candidate.clear = admissible_.admits(s.point, candidate.direction, query_);
  s.asked[candidate.direction] = candidate.clear ? kClear : kStopped;
  return candidate.clear;
}

/// Takes out the station's candidates that are not admissible: all of them or, in the order of what they
/// would cost between the axes `before` and `after` (null: none), those up to the first that is.
void Stations::sift(std::size_t i, const Vec3* before, const Vec3* after, bool all) {
  Station& s = stations_[i];
  struct Neighbour {
    const Vec3* axis;
    double price, least_cosine;
  };
  const auto neighbour = [&](const Vec3* axis, std::size_t at) {
    const double way = axis != nullptr ? std::abs(stations_[at].way - s.way) : 1.0;
    return Neighbour{axis, scale_ * scale_ / way, std::cos(std::min(kPi, max_turn_ * way + kRounding))};
  };
  const auto turn_cost = [](const Neighbour& to, Vec3 axis) {
    if (to.axis == nullptr) return 0.0;
    const double cosine = dot(*to.axis, axis);
    return cosine < to.least_cosine ? kJumpLength : to.price * (2.0 - 2.0 * cosine);
  };
  const Neighbour from = neighbour(before, i - 1), to = neighbour(after, i + 1);
  std::vector<std::pair<double, std::uint32_t>> order;
  order.reserve(s.candidates.size());
  for (std::uint32_t k = 0; k < s.candidates.size(); ++k) {
    const AxisCandidate& c = s.candidates[k];
    order.emplace_back(all ? 0.0 : c.cost + turn_cost(from, c.axis) + turn_cost(to, c.axis), k);
  }
  std::make_heap(order.begin(), order.end(), std::greater<>());
  std::vector<std::uint8_t> out(s.candidates.size(), 0);
  for (auto end = order.end(); end != order.begin(); --end) {
    std::pop_heap(order.begin(), end, std::greater<>());
    const std::uint32_t k = (end - 1)->second;
    out[k] = holds(s, s.candidates[k]) ? 0 : 1;
    if (out[k] == 0 && !all) break;
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < out.size(); ++k)
    if (out[k] == 0) s.candidates[kept++] = s.candidates[k];
  s.candidates.resize(kept);
  if (s.candidates.empty()) widen(i);
}

/// The cheapest sequence of the stations first..last, of admissible candidates only.
void Stations::settle(std::size_t first, std::size_t last) {
  std::vector<const AxisCandidates*> candidates;
  std::vector<double> ways;
  for (std::size_t i = first; i <= last; ++i) {
    candidates.push_back(&stations_[i].candidates);
    if (i > first) ways.push_back(stations_[i].way - stations_[i - 1].way);
  }
  CheapestSequence cheapest(std::move(candidates), std::move(ways),
                            {scale_ * scale_, max_turn_, kRounding, kJumpLength}, &admissible_.near());
  bool cut = false;
  std::size_t changed = first;
  for (int round = 0; !cut; ++round) {
    const auto chosen = cheapest.find(changed - first);
    changed = last + 1;
    for (std::size_t i = first; i <= last; ++i)
      stations_[i].chosen = stations_[i].candidates[chosen[i - first]].axis;
    for (std::size_t i = first; i <= last; ++i) {
      if (holds(stations_[i], stations_[i].candidates[chosen[i - first]])) continue;
      sift(i, i > first ? &stations_[i - 1].chosen : nullptr, i < last ? &stations_[i + 1].chosen : nullptr,
           round >= kFewRounds);
      changed = std::min(changed, i), cut |= stations_[i].candidates.empty();
    }
    if (changed > last) return;
  }
  settle_between(first, last);
}

/// Of the stations first..last some have no admissible direction: the stretches between these.
void Stations::settle_between(std::size_t first, std::size_t last) {
  for (std::size_t i = first; i <= last;) {
    std::size_t end = i;
    while (end <= last && !stations_[end].candidates.empty()) ++end;
    if (end > i) settle(i, end - 1);
    i = end + 1;
  }
}

/// Settles the stretches between stations with one candidate, which need not be settled together.
void Stations::settle() {
  const auto ends = [&](std::size_t i) { return i == stations_.size() || stations_[i].candidates.empty(); };
  for (std::size_t first = 0; first < stations_.size();) {
    if (ends(first)) {
      ++first;
      continue;
    }
    std::size_t last = first;
    bool changed = stations_[first].changed;
    while (!ends(last + 1)) {
      changed |= stations_[++last].changed;
      if (stations_[last].candidates.size() == 1 && stations_[last].candidates[0].clear) break;
    }
    if (changed) settle(first, last);
    // A station with one candidate ends one stretch and begins the next.
    first = last > first && !ends(last + 1) ? last : last + 1;
  }
  for (Station& s : stations_) s.changed = false;
}

void Stations::choose() {
  for (int further = 0;; ++further) {
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      Station& s = stations_[i];
      if (s.changed) price(i);
      if (s.candidates.empty() && s.window < kPi) widen(i);
    }
    settle();
    if (further == kFurther || !look_further()) break;
  }
  for (std::size_t i = 0; i < stations_.size(); ++i)
    if (stations_[i].coarse) narrow(i);
  settle();
}

}  // namespace tiltfeed::pathgen
