#include "pathgen/envelope.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tiltfeed {

namespace {

/// Share of the tolerance that a steep flank may lean: the step at which the search for its foot ends.
constexpr double kFlankShare = 0.1;

/// An arc leaves its chord by a quarter of what its end leaves the tangent, to first order; a little more for
/// the rest.
constexpr double kArcShare = 0.26;
/// Where the surface ends, usually on a flank, its end is found this closely (mm): a ball of radius R is then
/// within sqrt(2 R kEndStep) of the end of the flank.
constexpr double kEndStep = 1e-7;

struct Sample {
  double run = 0.0;
  bool hit = false;
  EnvelopePoint point;
};

/// Builds the envelope of one slice by evaluating it where patches begin and end, and between those places
/// until the straight moves fit. Heights come from the patches' closed forms.
class Profile {
 public:
  Profile(const ClSurface& surface, const Deformation& map, const Slices& slices, std::size_t k,
          const EnvelopeOptions& options)
      : surface_(surface),
        map_(map),
        along_(slices.along),
        level_(slices.level(k)),
        all_(slices.of(k)),
        near_(slices.near),
        options_(options) {
    flank_ = options.tolerance * kFlankShare;
    // (E3) Between two points of one sheet another curved sheet can rise by its sagitta over the gap.
    curved_step_ = std::sqrt(8.0 * surface.radius() * options.tolerance);
  }

  SliceEnvelope build() {
    const std::vector<double> breaks = break_points();
    std::size_t next = 0;
    std::optional<Sample> left;
    for (std::size_t i = 0; i + 1 < breaks.size() || (i < breaks.size() && breaks.size() == 1); ++i) {
      const double from = breaks[i], to = breaks[std::min(i + 1, breaks.size() - 1)];
      std::erase_if(active_, [&](const Candidate& c) { return c.to < from; });
      while (next < all_.size() && all_[next].from <= to) {
        if (all_[next].to >= from) active_.push_back(all_[next]);
        ++next;
      }
      if (!left) {
        left = evaluate(from);
        emit(*left);
      }
      const Sample right = evaluate(to);
      refine(*left, right);
      emit(right);
      left = right;
    }
    finish_pass();
    std::sort(result_.too_near.begin(), result_.too_near.end());
    result_.too_near.erase(std::unique(result_.too_near.begin(), result_.too_near.end()),
                           result_.too_near.end());
    return std::move(result_);
  }

 private:
  /// Ends of the candidates' intervals, those closer than the flank step taken as one.
  std::vector<double> break_points() const {
    std::vector<double> breaks;
    breaks.reserve(all_.size() * 2);
    for (const Candidate& c : all_) breaks.push_back(c.from), breaks.push_back(c.to);
    std::sort(breaks.begin(), breaks.end());
    const auto close = [this](double a, double b) { return b - a < flank_; };
    const double last = breaks.empty() ? 0.0 : breaks.back();
    breaks.erase(std::unique(breaks.begin(), breaks.end(), close), breaks.end());
    if (!breaks.empty() && breaks.back() < last)
      breaks.push_back(last);  // the slice ends there, not a little before
    return breaks;
  }

  /// Does the part grown by the radius hold the place where the column ends? Then the column is shut from
  /// there down to wherever that body ends, which its own patches need not show.
  bool end_is_covered(double x, double y) {
    if (near_.empty()) return false;
    const std::optional<Point<Part>> end = map_.column_end(x, y);
    if (!end) return false;
    for (PatchId patch : near_) {
      if (!surface_.covers(patch, *end)) continue;
      result_.too_near.push_back(patch);
      return true;
    }
    return false;
  }

  /// (E1) The highest of the active patches on the axis line at `run`; equal heights: the lower patch number.
  Sample evaluate(double run) {
    Sample sample;
    sample.run = run;
    const double x = along_ == Along::kX ? run : level_, y = along_ == Along::kX ? level_ : run;
    const AxisLine line = map_.axis_line(x, y);
    if (end_is_covered(x, y)) return sample;
    ClHit best;
    for (const Candidate& c : active_) {
      ClHit hit;
      if (c.from > run || c.to < run || !surface_.top(c.patch, line, hit)) continue;
      if (!map_.in_column({x, y, hit.z}, 0.0)) continue;  // seen from its own column
      const bool wins = !sample.hit || hit.z > best.z || (hit.z == best.z && c.patch < sample.point.patch);
      if (!wins) continue;
      best = hit;
      sample.hit = true;
      sample.point.patch = c.patch;
    }
    // Too near to where the column ends, or beyond it: nothing lower may be taken instead.
    if (sample.hit && !map_.in_column({x, y, best.z}, kLeastAxisDistance)) {
      sample.hit = false;
      result_.too_near.push_back(sample.point.patch);
    }
    if (!sample.hit) return sample;
    sample.point.flat = {x, y, best.z};
    sample.point.centre = line.base + line.axis * best.z;
    sample.point.axis = line.axis;
    sample.point.normal = best.normal;
    return sample;
  }

  /// (E2) How far the tangent planes at two points are from the other point, the larger and the smaller. The
  /// envelope between them leaves the straight move by no more than the smaller if it is two planes, by a
  /// quarter of either if it is an arc.
  struct Lift {
    double larger, smaller;
  };
  static Lift lift(const EnvelopePoint& a, const EnvelopePoint& b) {
    const Vec3 chord = b.centre - a.centre;
    const double from_a = std::abs(dot(a.normal, chord)), from_b = std::abs(dot(b.normal, chord));
    const double share = a.patch == b.patch ? kArcShare : 1.0;
    return {std::max(from_a, from_b) * share, std::min(from_a, from_b) * share};
  }

  bool another_curved_sheet(const Sample& left, const Sample& right) const {
    return std::any_of(active_.begin(), active_.end(), [&](const Candidate& c) {
      return !surface_.is_face(c.patch) && c.from <= left.run && c.to >= right.run &&
             c.patch != left.point.patch && c.patch != right.point.patch;
    });
  }

  bool short_enough(const Sample& left, const Sample& right) const {
    if (length(cross(left.point.axis, right.point.axis)) > options_.max_axis_step) return false;
    return distance(left.point.centre, right.point.centre) <= curved_step_ ||
           !another_curved_sheet(left, right);
  }

  /// Emits what is needed strictly between two samples.
  void refine(const Sample& left, const Sample& right) {
    if (right.run - left.run <= (left.hit == right.hit ? flank_ : kEndStep)) return;
    const bool joined = left.hit && right.hit && short_enough(left, right);
    const Lift rise = joined ? lift(left.point, right.point) : Lift{};
    if (joined && rise.larger <= options_.tolerance) return;
    const Sample middle = evaluate((left.run + right.run) / 2.0);
    if (!left.hit && !right.hit && !middle.hit) return;
    // A corner next to one end: the middle shows whether it is no more than that.
    if (joined && middle.hit && rise.smaller <= options_.tolerance &&
        distance_to_segment(middle.point.centre, left.point.centre, right.point.centre) <= options_.tolerance)
      return;
    refine(left, middle);
    emit(middle);
    refine(middle, right);
  }

  void emit(const Sample& sample) {
    if (!sample.hit) return finish_pass();
    pass_.push_back(sample.point);
  }
  void finish_pass() {
    if (!pass_.empty()) result_.passes.push_back(std::move(pass_));
    pass_.clear();
  }

  const ClSurface& surface_;
  const Deformation& map_;
  Along along_;
  double level_;
  std::span<const Candidate> all_;
  std::span<const PatchId> near_;
  EnvelopeOptions options_;
  double flank_ = 0.0, curved_step_ = 0.0;
  std::vector<Candidate> active_;
  Pass pass_;
  SliceEnvelope result_;
};

}  // namespace

SliceEnvelope upper_envelope(const ClSurface& surface, const Deformation& deformation, const Slices& slices,
                             std::size_t k, const EnvelopeOptions& options) {
  return Profile(surface, deformation, slices, k, options).build();
}

std::uint64_t leave_out(std::vector<std::vector<Pass>>& slices,
                        const std::function<bool(const EnvelopePoint&)>& unwanted) {
  std::uint64_t count = 0;
  for (auto& passes : slices) {
    std::vector<Pass> kept;
    for (const Pass& pass : passes) {
      Pass piece;
      for (const EnvelopePoint& p : pass) {
        if (!unwanted(p)) {
          piece.push_back(p);
          continue;
        }
        ++count;
        if (!piece.empty()) kept.push_back(std::move(piece));
        piece.clear();
      }
      if (!piece.empty()) kept.push_back(std::move(piece));
    }
    passes = std::move(kept);
  }
  return count;
}

Pass thinned(const Pass& pass, double tolerance, double max_axis_step) {
  Pass kept;
  if (pass.empty()) return kept;
  kept.push_back(pass.front());
  // (E4) Reach as far as every skipped point allows. The reach is capped, so that the work stays linear.
  constexpr std::size_t kLongestReach = 64;
  std::size_t from = 0;
  while (from + 1 < pass.size()) {
    std::size_t to = from + 1;
    for (std::size_t next = to + 1; next < pass.size() && next - from <= kLongestReach; ++next) {
      if (length(cross(pass[from].axis, pass[next].axis)) > max_axis_step) break;
      bool clear = true;
      for (std::size_t i = from + 1; i < next && clear; ++i)
        clear = distance_to_segment(pass[i].centre, pass[from].centre, pass[next].centre) <= tolerance;
      if (!clear) break;
      to = next;
    }
    kept.push_back(pass[to]);
    from = to;
  }
  return kept;
}

}  // namespace tiltfeed
