#include "daemon/plan/feed_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed::daemon {
namespace {

// Speeds that differ by no more than this factor become one, the lower; a stretch at a higher speed than its
// neighbours' that lasts no longer than this, s, is not worth it.
constexpr double kSameSpeed = 1.06, kShortest = 0.03;
// Spans that follow each other begin where the one before ends, but for rounding, s.
constexpr double kSameTime = 1e-5;

/// (FE1) The largest speed that no limit forbids.
double allowed(const LoadSpan& span, const Loads& limits) {
  double speed = std::numeric_limits<double>::infinity();
  if (span.chip > 0.0) speed = std::min(speed, limits.chip / span.chip);
  for (const auto& [load, limit] :
       {std::pair{span.edge_load, limits.edge_load}, {span.turn_load, limits.turn_load}})
    if (load > 0.0) speed = std::min(speed, std::pow(limit / load, 1.0 / kLoadExponent));
  return speed;
}

class Profile {
 public:
  Profile(const std::vector<LoadSpan>& spans, const Loads& limits, const FeedRule& rule)
      : spans_(spans), rule_(rule) {
    for (const LoadSpan& span : spans)
      most_.push_back(span.cut ? std::min(allowed(span, limits), rule.highest) : 1.0);
  }

  std::vector<SpeedStep> steps() {
    look_ahead();
    if (rule_.change > 0.0) limit_change();
    round_down();
    merge();
    return std::move(steps_);
  }

 private:
  /// One goes on from the other at feed, and both cut.
  bool follows(std::size_t i) const {
    return i > 0 && i < spans_.size() && spans_[i].cut && spans_[i - 1].cut &&
           spans_[i].begin - spans_[i - 1].end <= kSameTime;
  }

  /// (FE2) What lies ahead counts now, and what lies just behind still does.
  void look_ahead() {
    const std::vector<double> own = most_;
    for (std::size_t i = 0; i < spans_.size(); ++i) {
      if (!spans_[i].cut) continue;
      if (follows(i)) most_[i] = std::min(most_[i], own[i - 1]);
      double way = 0.0;
      for (std::size_t k = i + 1; follows(k) && way <= rule_.ahead; way += spans_[k++].way)
        most_[i] = std::min(most_[i], own[k]);
    }
  }

  /// (FE3)
  void limit_change() {
    const auto step = [&](std::size_t i) { return rule_.change * 0.5 * (spans_[i].way + spans_[i - 1].way); };
    for (std::size_t i = 1; i < spans_.size(); ++i)
      if (follows(i)) most_[i] = std::min(most_[i], most_[i - 1] + step(i));
    for (std::size_t i = spans_.size(); i-- > 1;)
      if (follows(i)) most_[i - 1] = std::min(most_[i - 1], most_[i] + step(i));
  }

  void round_down() {
    const double least = std::ceil(rule_.lowest / kSpeedStep - 1e-9) * kSpeedStep;
    for (std::size_t i = 0; i < spans_.size(); ++i)
      if (spans_[i].cut)
        most_[i] = std::max(std::floor(most_[i] / kSpeedStep + 1e-9) * kSpeedStep, std::min(least, 1.0));
  }

  /// (FE4)
  void merge() {
    struct Run {
      double begin, end, lowest, highest;
      bool cut, joined;
      double seconds() const { return (end - begin) / lowest; }
    };
    std::vector<Run> runs;
    for (std::size_t i = 0; i < spans_.size(); ++i) {
      const LoadSpan& span = spans_[i];
      const bool joined = follows(i);
      if (joined &&
          std::max(runs.back().highest, most_[i]) <= kSameSpeed * std::min(runs.back().lowest, most_[i])) {
        Run& run = runs.back();
        run.end = span.end, run.lowest = std::min(run.lowest, most_[i]);
        run.highest = std::max(run.highest, most_[i]);
        continue;
      }
      runs.push_back({span.begin, span.end, most_[i], most_[i], span.cut, joined});
    }
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (!runs[i].cut || runs[i].seconds() > kShortest) continue;
      const double before = runs[i].joined ? runs[i - 1].lowest : 0.0,
                   behind = i + 1 < runs.size() && runs[i + 1].joined ? runs[i + 1].lowest : 0.0;
      const double beside = std::max(before, behind);
      if (beside > 0.0) runs[i].lowest = std::min(runs[i].lowest, beside);
    }
    double at = 0.0;
    const auto put = [&](double end, double speed) {
      if (!(end > at)) return;
      if (!steps_.empty() && steps_.back().speed == speed)
        steps_.back().end = end;
      else
        steps_.push_back({end, speed});
      at = end;
    };
    for (const Run& run : runs) {
      if (!run.joined && run.begin > at + kSameTime) put(run.begin, 1.0);
      put(run.end, run.lowest);
    }
  }

  const std::vector<LoadSpan>& spans_;
  const FeedRule& rule_;
  std::vector<double> most_;
  std::vector<SpeedStep> steps_;
};

}  // namespace

Loads largest_loads(const std::vector<LoadSpan>& spans) {
  Loads most;
  for (const LoadSpan& span : spans) {
    if (!span.cut) continue;
    const double power = std::pow(span.pace, kLoadExponent);
    most.chip = std::max(most.chip, span.chip * span.pace);
    most.edge_load = std::max(most.edge_load, span.edge_load * power);
    most.turn_load = std::max(most.turn_load, span.turn_load * power);
  }
  return most;
}

std::vector<SpeedStep> feed_profile(const std::vector<LoadSpan>& spans, const Loads& limits,
                                    const FeedRule& rule) {
  return Profile(spans, limits, rule).steps();
}

}  // namespace tiltfeed::daemon
