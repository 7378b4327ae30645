#include "pathgen/envelope/pass_floor.h"

#include <algorithm>
#include <limits>

namespace tiltfeed::pathgen {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Run coordinates of one point, taken from its place, differ by less (mm).
constexpr double kSame = 1e-9;

double run_of(const FlatLine& line, const EnvelopePoint& p) { return line.run_of(p.flat.x, p.flat.y); }

}  // namespace

PassFloor::PassFloor(std::span<const Pass> passes, const FlatLine& line, double slack, double least)
    : least_(least), spare_(slack) {
  run_.push_back(-kInfinity), low_.push_back(least);
  for (const Pass& pass : passes) {
    for (std::size_t i = 0; i < pass.size(); ++i) {
      run_.push_back(run_of(line, pass[i]));
      low_.push_back(i + 1 < pass.size()
                         ? std::max(std::min(pass[i].flat.z, pass[i + 1].flat.z) - slack, least)
                         : least);
    }
    // A candidate that ends with the pass ends no further.
    run_[run_.size() - pass.size()] -= kSame, run_.back() += kSame;
  }
  run_.push_back(kInfinity);
  sum_up();
}

void PassFloor::sum_up() {
  lowest_.assign(1, low_);
  for (std::size_t width = 1; 2 * width <= low_.size(); width *= 2) {
    const std::vector<double>& half = lowest_.back();
    std::vector<double> whole(low_.size() - 2 * width + 1);
    for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = std::min(half[i], half[i + width]);
    lowest_.push_back(std::move(whole));
  }
}

bool PassFloor::open_over(std::span<const Pass> passes, const FlatLine& line) {
  bool opened = false;
  for (const Pass& pass : passes)
    for (std::size_t i = 0; i < pass.size(); ++i) {
      const std::size_t next = std::min(i + 1, pass.size() - 1);
      const double low = std::min(pass[i].flat.z, pass[next].flat.z);
      const auto [first, last] = moves(run_of(line, pass[i]), run_of(line, pass[next]));
      for (std::size_t k = first; k < last; ++k)
        if (low < low_[k] && low_[k] > least_) low_[k] = std::max(low - spare_, least_), opened = true;
    }
  spare_ *= 2.0;
  if (opened) sum_up();
  return opened;
}

std::pair<std::size_t, std::size_t> PassFloor::moves(double from, double to) const {
  const auto first = std::upper_bound(run_.begin(), run_.end(), from) - 1;
  const auto last = std::lower_bound(first + 1, run_.end(), to);
  return {static_cast<std::size_t>(first - run_.begin()), static_cast<std::size_t>(last - run_.begin())};
}

double PassFloor::lowest(double from, double to) const {
  const auto [first, last] = moves(from, to);
  std::size_t level = 0;
  while ((std::size_t{2} << level) <= last - first) ++level;
  return std::min(lowest_[level][first], lowest_[level][last - (std::size_t{1} << level)]);
}

std::vector<std::pair<double, double>> PassFloor::stretches(std::span<const Candidate> candidates,
                                                            double length) const {
  std::vector<std::pair<double, double>> all;
  for (const Candidate& c : candidates) {
    const auto [first, last] = moves(c.from, c.to);
    all.push_back({std::max(run_[first], 0.0), std::min(run_[last], length)});
  }
  std::sort(all.begin(), all.end());
  std::size_t count = 0;
  for (const auto& s : all) {
    if (count > 0 && s.first <= all[count - 1].second)
      all[count - 1].second = std::max(all[count - 1].second, s.second);
    else
      all[count++] = s;
  }
  all.resize(count);
  return all;
}

void PassSplice::copy_before(double run) {
  for (; pass_ < passes_.size(); ++pass_, point_ = 0, open_ = false)
    for (const Pass& pass = passes_[pass_]; point_ < pass.size(); ++point_, open_ = true) {
      if (run_of(line_, pass[point_]) >= run) return;
      if (!open_) result_.emplace_back();
      result_.back().push_back(pass[point_]);
    }
}

void PassSplice::replace(double from, double to, std::vector<Pass> by) {
  copy_before(from - 2.0 * kSame);
  for (Pass& pass : by) {
    const bool goes_on = open_ && &pass == &by.front() && run_of(line_, pass.front()) <= from + 2.0 * kSame;
    if (!goes_on) {
      result_.push_back(std::move(pass));
    } else {
      result_.back().insert(result_.back().end(), pass.begin(), pass.end());
    }
  }
  const bool reaches = !by.empty() && run_of(line_, result_.back().back()) >= to - 2.0 * kSame;
  open_ = false;
  for (; pass_ < passes_.size(); ++pass_, point_ = 0, open_ = false)
    for (const Pass& pass = passes_[pass_]; point_ < pass.size(); ++point_, open_ = reaches)
      if (run_of(line_, pass[point_]) > to + 2.0 * kSame) return;
}

std::vector<Pass> PassSplice::finish() {
  copy_before(kInfinity);
  return std::move(result_);
}

}  // namespace tiltfeed::pathgen
