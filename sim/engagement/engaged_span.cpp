#include "sim/engagement/engaged_span.h"

#include <algorithm>
#include <cmath>

#include "sim/removal/tool_sweep.h"

namespace tiltfeed::sim {
namespace {

// A rapid cuts nothing as a rule: its spans are so many times as long.
constexpr double kRapidSteps = 8.0;
constexpr int kMostSpansPerMove = 20000;

class SpanMaker {
 public:
  SpanMaker(const ExecutedPath& path, const FrameChain& chain, const SpanOptions& options)
      : path_(path), chain_(chain), options_(options) {}

  void take(std::size_t move) {
    const ExecutedMove& one = path_.moves[move];
    const Joints& start = path_.from(move);
    const Pose from = chain_(start), to = chain_(one.to), middle = chain_(between(start, one.to, 0.5));
    const double step = options_.step * (one.rapid ? kRapidSteps : 1.0);
    const double pieces =
        std::max(measure(from, to) / step, std::sqrt(bow(from, middle, to) / options_.stray));
    const int count = static_cast<int>(std::ceil(std::clamp(pieces, 1.0, 1.0 * kMostSpansPerMove)));
    Pose last = from;
    for (int i = 0; i < count; ++i) {
      const double begin = static_cast<double>(i) / count, end = static_cast<double>(i + 1) / count;
      const Pose next = i + 1 == count ? to : chain_(between(start, one.to, end));
      EngagedSpan piece{
          static_cast<std::uint32_t>(move), static_cast<std::uint32_t>(move), begin, end, last, next};
      piece.way = distance(last.tip, next.tip);
      piece.asked = one.asked / count, piece.took = (one.end - one.start) / count, piece.rapid = one.rapid;
      add(piece, step);
      last = next;
    }
  }

  std::vector<EngagedSpan> spans;

 private:
  double measure(const Pose& from, const Pose& to) const {
    return std::max(distance(from.tip, to.tip),
                    distance(on_axis(from, options_.top), on_axis(to, options_.top)));
  }
  /// How far the middle is off the straight way.
  double bow(const Pose& from, const Pose& middle, const Pose& to) const {
    const auto off = [&](double h) {
      return distance(on_axis(middle, h), lerp(on_axis(from, h), on_axis(to, h), 0.5));
    };
    return std::max(off(0.0), off(options_.top));
  }
  bool joins(const EngagedSpan& piece, double step) const {
    if (spans.empty() || spans.back().rapid != piece.rapid) return false;
    const EngagedSpan& open = spans.back();
    if (measure(open.from, piece.to) > step) return false;
    const auto near = [&](const Pose& pose, double h) {
      return distance_to_segment(on_axis(pose, h), on_axis(open.from, h), on_axis(piece.to, h)) <=
             options_.stray;
    };
    // To and fro is two ways.
    if (dot(open.to.tip - open.from.tip, piece.to.tip - piece.from.tip) < 0.0) return false;
    return std::all_of(corners_.begin(), corners_.end(),
                       [&](const Pose& pose) { return near(pose, 0.0) && near(pose, options_.top); }) &&
           near(piece.from, 0.0) && near(piece.from, options_.top);
  }
  void add(const EngagedSpan& piece, double step) {
    if (!joins(piece, step)) {
      spans.push_back(piece);
      corners_.clear();
      return;
    }
    corners_.push_back(piece.from);
    EngagedSpan& open = spans.back();
    open.last_move = piece.last_move, open.end = piece.end, open.to = piece.to;
    open.way += piece.way, open.asked += piece.asked, open.took += piece.took;
  }

  const ExecutedPath& path_;
  const FrameChain& chain_;
  const SpanOptions& options_;
  std::vector<Pose> corners_;  ///< within the last span
};

}  // namespace

std::vector<EngagedSpan> engaged_spans(const ExecutedPath& path, const FrameChain& chain,
                                       const SpanOptions& options, std::size_t begin, std::size_t end) {
  SpanMaker maker(path, chain, options);
  for (std::size_t move = begin; move < end; ++move) maker.take(move);
  return std::move(maker.spans);
}

}  // namespace tiltfeed::sim
