#include "pathgen/surface/candidates.h"

#include <algorithm>
#include <functional>
#include <numeric>

namespace tiltfeed::pathgen {

namespace {

/// On a shorter line (mm) all candidates start in one bin.
constexpr double kShort = 1e-9;
/// So many are moved to their places one by one.
constexpr std::size_t kFew = 4;

}  // namespace

void join_pieces(std::vector<Candidate>& pieces, std::vector<Candidate>& candidates) {
  std::sort(pieces.begin(), pieces.end(), [](const Candidate& a, const Candidate& b) {
    if (a.patch != b.patch) return a.patch < b.patch;
    if (a.from != b.from) return a.from < b.from;
    return a.to < b.to;
  });
  const std::size_t first = candidates.size();
  for (const Candidate& piece : pieces) {
    if (candidates.size() > first && candidates.back().patch == piece.patch &&
        piece.from <= candidates.back().to) {
      candidates.back().to = std::max(candidates.back().to, piece.to);
      candidates.back().top = std::max(candidates.back().top, piece.top);
    } else {
      candidates.push_back(piece);
    }
  }
}

/// They are spread over as many bins as there are, then each bin is sorted.
void sort_by_start(std::vector<Candidate>& candidates, double length, CandidateSorting& room) {
  const std::size_t count = candidates.size();
  if (count == 0) return;
  const double per_mm = length > kShort ? static_cast<double>(count) / length : 0.0;
  const auto bin = [&](const Candidate& c) {
    return std::min(static_cast<std::size_t>(c.from * per_mm), count - 1);
  };
  std::vector<std::uint32_t>& start = room.start;
  start.assign(count + 1, 0);
  for (const Candidate& c : candidates) ++start[bin(c) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  room.candidates.resize(count);
  for (const Candidate& c : candidates) room.candidates[start[bin(c)]++] = c;
  candidates.swap(room.candidates);
  std::uint32_t from = 0;  // each start has moved on to the end of its bin
  for (std::size_t b = 0; b < count; from = start[b++]) {
    if (start[b] - from < 2) continue;
    std::sort(candidates.begin() + from, candidates.begin() + start[b],
              [](const Candidate& p, const Candidate& q) {
                if (p.from != q.from) return p.from < q.from;
                if (p.patch != q.patch) return p.patch < q.patch;
                return p.to < q.to;
              });
  }
}

bool CandidateSweep::next() {
  constexpr double kNowhere = std::numeric_limits<double>::infinity();
  if (all_.empty()) return false;
  const bool first = next_ == 0;
  from_ = first ? all_.front().from : to_;
  const double close = first ? 0.0 : close_;
  if (some_end_) drop_ended();
  while (next_ < all_.size() && all_[next_].from - from_ < close) take_next();
  to_ = next_ < all_.size() ? all_[next_].from : kNowhere;
  double last = from_;
  for (; !ends_.empty() && ends_.front() - from_ < close; some_end_ = true) last = next_end();
  if (!ends_.empty()) to_ = std::min(to_, ends_.front());
  if (to_ == kNowhere) to_ = last;
  if (to_ == from_ && !first) return false;
  while (next_ < all_.size() && all_[next_].from <= to_) take_next();
  return true;
}

/// Those that ended by less than `close` beyond the last break.
void CandidateSweep::drop_ended() {
  const auto is_ended = [&](const Candidate& c) { return c.to < from_; };
  const auto taken = active_.begin() + static_cast<std::ptrdiff_t>(settled_);
  const auto kept = std::remove_if(active_.begin(), taken, is_ended);
  settled_ = static_cast<std::size_t>(kept - active_.begin());
  active_.erase(std::move(taken, std::remove_if(taken, active_.end(), is_ended), kept), active_.end());
  some_end_ = false;
}

void CandidateSweep::take_next() {
  const Candidate& c = all_[next_++];
  if (c.to < from_) return;
  ends_.push_back(c.to);
  std::push_heap(ends_.begin(), ends_.end(), std::greater<>());
  active_.push_back(c);
}

double CandidateSweep::next_end() {
  const double end = ends_.front();
  std::pop_heap(ends_.begin(), ends_.end(), std::greater<>());
  ends_.pop_back();
  return end;
}

/// Brings those just taken to their places; of equals the one taken first comes first.
void CandidateSweep::settle() {
  const auto higher = [](const Candidate& a, const Candidate& b) { return a.top > b.top; };
  const auto taken = active_.begin() + static_cast<std::ptrdiff_t>(settled_);
  const bool many = active_.size() - settled_ > kFew;
  settled_ = active_.size();
  if (many) {
    std::stable_sort(taken, active_.end(), higher);
    return std::inplace_merge(active_.begin(), taken, active_.end(), higher);
  }
  for (auto c = taken; c != active_.end(); ++c) {
    const Candidate one = *c;
    const auto place = std::upper_bound(active_.begin(), c, one, higher);
    std::move_backward(place, c, c + 1);
    *place = one;
  }
}

}  // namespace tiltfeed::pathgen
