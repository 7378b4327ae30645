#include "pathgen/envelope/envelope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "pathgen/envelope/highest_patch.h"
#include "pathgen/envelope/pass_floor.h"
#include "pathgen/envelope/straight_moves.h"
#include "pathgen/envelope/surface_end.h"

namespace tiltfeed::pathgen {

namespace {

/// Share of the tolerance that a steep flank may lean: the step at which the search for its foot ends.
constexpr double kFlankShare = 0.1;

/// Lines shorter than this share of the index's spacing are looked up like places.
constexpr double kNearShare = 0.5;

/// A line that goes further round the axis feature between two places, rad, may come back to nearly the
/// first: what lies between does not show in the way from one to the other.
constexpr double kMostWound = kPi / 2.0;

/// So many tolerances below the lowest of three places, and by as much as these differ, patches no longer
/// count.
constexpr double kBelow = 8.0;

/// So many hulls over one place are a crowd: from there on the tree costs less than the list.
constexpr std::size_t kCrowd = 512;
/// So few candidates of a line are gone through one by one.
constexpr std::size_t kFew = 64;

}  // namespace

/// Builds the envelope along one line by evaluating it where patches begin and end, and between those places
/// until the straight moves fit. Heights come from the patches' closed forms.
class Profile {
 public:
  /// `chosen`: the candidates are those that come near the envelope; few are gone through one by one.
  Profile(Envelope& field, const FlatLine& line, bool chosen = false)
      : field_(field),
        surface_(field.surface_),
        map_(field.map_),
        line_(line),
        options_(field.options_),
        moves_(surface_, options_, stretch(field, line)),
        flank_(options_.tolerance * kFlankShare),
        wound_(winding(map_, line)),
        sweep_(field.candidates_, moves_.close()),
        few_(chosen && field.candidates_.size() <= kFew) {}

  LineEnvelope build() {
    if (!sweep_.next()) return {};
    pass_.reserve(2 * field_.candidates_.size());
    std::array<Sample, 2> ends{evaluate(sweep_.to())};
    emit(ends[0]);
    for (std::size_t i = 0; sweep_.next(); ++i) {
      const Sample& left = ends[i % 2];
      Sample& right = ends[(i + 1) % 2];
      right = evaluate(sweep_.to());
      refine(left, right);
      emit(right);
    }
    finish_pass();
    std::sort(result_.too_near.begin(), result_.too_near.end());
    result_.too_near.erase(std::unique(result_.too_near.begin(), result_.too_near.end()),
                           result_.too_near.end());
    return std::move(result_);
  }

  /// The envelope at the start of the line, near which the envelope has looked unless it asks the tree.
  Sample start() {
    at_place_ = true;
    return evaluate(0.0);
  }
  /// Is it higher than `z` there?
  bool rises_over(double z) {
    const double x = line_.x, y = line_.y;
    const AxisLine line = map_.axis_line(x, y, angles_);
    if (end_is_covered(x, y, line.axis)) return false;
    HighestPatch highest(surface_, map_, angles_, line);
    highest.ask_over(z);
    take_at(highest, x, y);
    field_.count(highest.cost());
    return highest.found();
  }
  /// The patch for which nothing may be cut there.
  std::optional<PatchId> shut_by() const {
    return result_.too_near.empty() ? std::nullopt : std::optional(result_.too_near.front());
  }

 private:
  /// The most that a step along the line is longer on the CL surface.
  static double stretch(const Envelope& field, const FlatLine& line) {
    const Deformation::Stretch most = field.map_.stretch(field.index_.furthest());
    return std::abs(line.dx) * most.x + std::abs(line.dy) * most.y;
  }

  /// How far the line goes round the axis feature, rad for a mm of it.
  static double winding(const Deformation& map, const FlatLine& line) {
    if (map.frame().mode == AxisMode::kFixed) return 0.0;
    const double by_x = map.period_x() > 0.0 ? std::abs(line.dx) / map.scale_x() : 0.0;
    return by_x + std::abs(line.dy) / map.scale_y();
  }

  /// Does the part grown by the radius hold the place where the column ends? Then the column is shut from
  /// there down to wherever that body ends, which its own patches need not show.
  bool end_is_covered(double x, double y, Vec3 axis) {
    const ColumnEnds& near = field_.index_.covering();
    if (near.empty()) return false;
    const std::optional<Point<Part>> end = map_.column_end(x, y);
    if (!end) return false;
    // Where the ring is not at the reference, its place depends on the axis, too.
    const std::pair asked{*end, axis * surface_.pieces().front().above_reference};
    if (!field_.end_ || *field_.end_ != asked) {
      field_.end_ = asked;
      field_.end_covered_by_ =
          near.first_over(*end, [&](PatchId patch) { return surface_.covers(patch, *end, axis); });
    }
    if (field_.end_covered_by_) result_.too_near.push_back(*field_.end_covered_by_);
    return field_.end_covered_by_.has_value();
  }

  /// (E1) The highest of the active patches on the axis line at `run`; equal heights: the lower patch number.
  Sample evaluate(double run) {
    Sample sample;
    sample.run = run;
    const double x = line_.x_at(run), y = line_.y_at(run);
    const AxisLine line = map_.axis_line(x, y, angles_);
    if (end_is_covered(x, y, line.axis)) return sample;
    HighestPatch highest(surface_, map_, angles_, line);
    if (at_place_) {
      take_at(highest, x, y);
    } else {
      take_on_line(highest, run);
    }
    if (!few_) field_.count(highest.cost());
    if (!highest.found()) return sample;
    sample.point.patch = highest.patch();
    if (!few_) field_.last_ = highest.best();
    const ClHit& best = highest.hit();
    // Too near to where the column ends, or beyond it: nothing lower may be taken instead.
    if (!map_.in_column(best.z, angles_, kLeastAxisDistance)) {
      result_.too_near.push_back(sample.point.patch);
      return sample;
    }
    sample.hit = true;
    sample.point.flat = {x, y, best.z};
    sample.point.centre = line.base + line.axis * best.z;
    sample.point.axis = line.axis;
    lean(best, sample.point);
    return sample;
  }

  /// The candidates at `run`, from the highest down or as the tree shows them.
  void take_on_line(HighestPatch& highest, double run) {
    if (field_.asks_tree() && !few_) return take_from_tree_on_line(highest, run);
    for (const Candidate& c : sweep_.active()) {
      if (c.from > run || c.to < run) continue;
      if (highest.is_over(c.top)) break;
      highest.take(c.patch);
    }
  }

  void take_from_tree_on_line(HighestPatch& highest, double run) {
    std::vector<Candidate>& all = field_.by_patch_;
    const auto below = [](const Candidate& c, PatchId patch) { return c.patch < patch; };
    if (!by_patch_) {
      all = field_.candidates_;
      std::sort(all.begin(), all.end(),
                [](const Candidate& a, const Candidate& b) { return a.patch < b.patch; });
      by_patch_ = true;
    }
    const auto is_there = [&](const DropBvh::Found& found) {
      for (auto c = std::lower_bound(all.begin(), all.end(), found.patch, below);
           c != all.end() && c->patch == found.patch; ++c)
        if (c->from <= run && c->to >= run) return true;
      return false;
    };
    highest.take(field_.last_, is_there);
    for (const DropBvh& drops : field_.drops_) {
      const auto c = std::lower_bound(all.begin(), all.end(), drops.first(), below);
      if (c == all.end() || c->patch > drops.last()) continue;
      highest.take_from(drops, line_.x_at(run), line_.y_at(run), is_there);
    }
  }

  /// The same of all that may be highest at a place, shank and holder included.
  void take_at(HighestPatch& highest, double x, double y) {
    if (field_.asks_tree()) return take_from_tree_at(highest, x, y);
    const auto take_from = [&](const HullBvh& tree) {
      tree.each(
          {x, x, y, y}, [&](const FlatBox&, float top) { return !highest.is_over(top); },
          [&](const HullBvh::Found& found) { highest.take(found.patch); });
    };
    if (field_.places_ != nullptr) {
      take_from(*field_.places_);
    } else {
      for (const FlatIndex::Nearby& n : field_.nearby_) {
        if (highest.is_over(n.top)) break;
        if (n.box.holds(x, y)) highest.take(n.patch);
      }
    }
    take_from(field_.index_.guards());
  }

  void take_from_tree_at(HighestPatch& highest, double x, double y) {
    const auto is_there = [&](const DropBvh::Found& found) { return field_.index_.holds(found, x, y); };
    highest.take(field_.last_, is_there);
    for (const DropBvh& drops : field_.drops_) highest.take_from(drops, x, y, is_there);
  }

  /// (C5) Normal of the CL surface: that of the contact, tilted by what the axis turns.
  void lean(const ClHit& hit, EnvelopePoint& point) const {
    point.normal = hit.normal;
    if (hit.twist == Vec3{}) return;
    const Vec3 tilted = hit.normal + map_.axis_turn(point.flat, hit.twist);
    const double lever = length(tilted);
    point.normal = tilted / lever;
    point.lever = static_cast<float>(std::max(1.0, lever));
  }

  /// Emits what is needed strictly between two samples. `looks`: for the end of the surface there so far.
  void refine(const Sample& left, const Sample& right, int looks = 0) {
    const double width = right.run - left.run;
    if (width <= (left.hit == right.hit ? flank_ : kEndStep)) return;
    const bool both = left.hit && right.hit && width * wound_ <= kMostWound;
    const StraightMoves::Verdict move =
        both ? moves_.judge(left, right, sweep_.active()) : StraightMoves::Verdict{};
    const bool plane =
        move.unbroken && move.larger <= options_.tolerance && !moves_.stands_level_on_two(left, right);
    const bool sinks = plane && !follows(left, right, left, right);
    if ((plane && !sinks) || move.over_one_edge) return;
    const Sample middle =
        evaluate(left.hit == right.hit ? left.run + width * moves_.next_share(left, right, move)
                                       : next_look(surface_, map_, line_, left, right, looks));
    if (!left.hit && !right.hit && !middle.hit) return;
    // A corner next to one end: the middle shows whether it is no more than that, and the quarters that there
    // are not two of them.
    const auto quarter = [&](double share) {
      return moves_.on_move(evaluate(left.run + share * width), left, right);
    };
    if (!sinks && move.unbroken && move.corner_at_end && middle.hit && moves_.on_move(middle, left, right) &&
        (StraightMoves::one_corner(left, middle, right) || (quarter(0.25) && quarter(0.75))) &&
        follows(left, middle, left, right) && follows(middle, right, left, right))
      return;
    refine(left, middle, looks + 1);
    emit(middle);
    refine(middle, right, looks + 1);
  }

  /// Does a sharp edge stay within the tolerance of the move between `from` and `to`, places of it?
  bool follows(const Sample& from, const Sample& to, const Sample& left, const Sample& right) {
    if (to.run - from.run <= flank_ || !moves_.may_sink(from.point, to.point)) return true;
    const Sample middle = evaluate(0.5 * (from.run + to.run));
    return moves_.on_move(middle, left, right) && follows(from, middle, left, right) &&
           follows(middle, to, left, right);
  }

  void emit(const Sample& sample) {
    if (!sample.hit) return finish_pass();
    pass_.push_back(sample.point);
  }
  void finish_pass() {
    if (!pass_.empty()) result_.passes.push_back(std::move(pass_));
    pass_.clear();
  }

  Envelope& field_;
  const ClSurface& surface_;
  const Deformation& map_;
  FlatLine line_;
  const EnvelopeOptions& options_;
  StraightMoves moves_;
  double flank_;
  double wound_;  ///< rad for a mm of the line
  Deformation::Angles angles_;
  CandidateSweep sweep_;
  bool few_;
  bool at_place_ = false;  ///< what is there is looked up, shank and holder too
  bool by_patch_ = false;  ///< that of the envelope is of this line
  Pass pass_;
  LineEnvelope result_;
};

void Envelope::look_along(const FlatLine& line) {
  if (line.length <= kNearShare * index_.spacing()) {
    look_near({line.x, line.y}, {line.x_at(line.length), line.y_at(line.length)});
    FlatIndex::along(line, nearby_, scratch_, candidates_);
  } else {
    index_.along(line, scratch_, candidates_);
  }
}

LineEnvelope Envelope::along(const FlatLine& line) { return along(line, kAnyHeight); }

LineEnvelope Envelope::along(const FlatLine& line, double z) {
  look_along(line);
  return along_candidates(line, z);
}

LineEnvelope Envelope::along(const FlatLine& line, const RowCandidates& rows, std::size_t row) {
  rows.of(row, met_);
  FlatIndex::along(line, met_, scratch_, candidates_);
  return along_candidates(line, kAnyHeight);
}

bool Envelope::may_rise_over(const FlatLine& line, double z) {
  index_.along(line, scratch_, candidates_);
  const auto is_over = [z](const auto& bound) { return static_cast<double>(bound.top) > z; };
  if (std::any_of(candidates_.begin(), candidates_.end(), is_over)) return true;
  bool over = false;
  index_.guards().each(
      box_round(line), [&](const FlatBox&, float top) { return !over && static_cast<double>(top) > z; },
      [&](const HullBvh::Found&) { over = true; });
  return over;
}

double Envelope::cutter_height(double x, double y) const {
  Deformation::Angles angles;
  const AxisLine there = map_.axis_line(x, y, angles);
  HighestPatch highest(surface_, map_, angles, there);
  for (const DropBvh& drops : index_.cutter_drops(surface_))
    highest.take_from(drops, x, y, [&](const DropBvh::Found& found) { return index_.holds(found, x, y); });
  return highest.found() ? highest.hit().z : kAnyHeight;
}

/// From the patches of the cutting part that come near its envelope in height; nothing where there is a gap
/// or what was found comes so low that others may count.
std::optional<LineEnvelope> Envelope::of_the_highest(const FlatLine& line, double z) {
  const double half = 0.5 * line.length;
  double low = std::numeric_limits<double>::infinity(), high = kAnyHeight;
  for (const double run : {0.0, half, line.length}) {
    const double height = cutter_height(line.x_at(run), line.y_at(run));
    low = std::min(low, height), high = std::max(high, height);
  }
  if (low == kAnyHeight) return std::nullopt;
  low -= (high - low) + kBelow * options_.tolerance;
  index_.along_over(line, map_.axis_line(line.x_at(half), line.y_at(half)), low, surface_, map_, scratch_,
                    candidates_);
  const double end = options_.tolerance * kFlankShare;
  const auto is_whole = [&](const LineEnvelope& found) {
    if (found.passes.size() != 1 || !found.too_near.empty()) return false;
    const Pass& pass = found.passes.front();
    return line.run_of(pass.front().flat.x, pass.front().flat.y) <= end &&
           line.run_of(pass.back().flat.x, pass.back().flat.y) >= line.length - end &&
           std::all_of(pass.begin(), pass.end(), [&](const EnvelopePoint& p) { return p.flat.z >= low; });
  };
  LineEnvelope found = Profile(*this, line, true).build();
  if (!is_whole(found)) return std::nullopt;
  // With shank and holder other places are asked: there the cutting part may be lower, too.
  found = guarded(std::move(found), line, z);
  return is_whole(found) ? std::optional(std::move(found)) : std::nullopt;
}

LineEnvelope Envelope::along_short(const FlatLine& line, double z) {
  if (auto found = of_the_highest(line, z)) return std::move(*found);
  return along(line, z);
}

bool Envelope::is_crowded(const FlatLine& line) const {
  if (line.length > surface_.pieces().front().outer) return false;
  std::size_t hulls = 0;
  const double half = 0.5 * line.length;
  return index_.any_at(line.x_at(half), line.y_at(half), [&](PatchId) { return ++hulls > kCrowd; });
}

LineEnvelope Envelope::along_candidates(const FlatLine& line, double least) {
  return guarded(Profile(*this, line).build(), line, least);
}

LineEnvelope Envelope::guarded(LineEnvelope found, const FlatLine& line, double least) {
  if (!has_guards()) return found;
  // The cutting part alone shows how low shank and holder come.
  PassFloor floor(found.passes, line, options_.tolerance, least);
  if (!find_guards(line, floor)) return found;
  cutter_.swap(candidates_);
  std::vector<Candidate> asked;
  for (;;) {
    LineEnvelope all = raised(found, line, floor);
    // A move along an edge stays up where its places, asked one by one, fall past the edge.
    if (!floor.open_over(all.passes, line)) return all;
    asked.swap(guards_);
    find_guards(line, floor);
    if (guards_ == asked) return all;  // the same would be traced once more
  }
}

/// The passes of the cutting part, traced again where shank or holder may rise over them.
LineEnvelope Envelope::raised(const LineEnvelope& found, const FlatLine& line, const PassFloor& floor) {
  LineEnvelope all;
  all.too_near = found.too_near, all.guarded = true;
  for (const Pass& pass : found.passes)
    all.cut.push_back({line.run_of(pass.front().flat.x, pass.front().flat.y),
                       line.run_of(pass.back().flat.x, pass.back().flat.y)});
  PassSplice splice(found.passes, line);
  for (const auto& [from, to] : floor.stretches(guards_, line.length)) {
    candidates_.clear();
    for (const std::vector<Candidate>* some : {&cutter_, &guards_})
      for (const Candidate& c : *some)
        if (c.from <= to && c.to >= from)
          candidates_.push_back({std::max(c.from, from), std::min(c.to, to), c.patch, c.top});
    sort_by_start(candidates_, line.length, scratch_.sorting);
    LineEnvelope part = Profile(*this, line).build();
    splice.replace(from, to, std::move(part.passes));
    all.too_near.insert(all.too_near.end(), part.too_near.begin(), part.too_near.end());
  }
  all.passes = splice.finish();
  std::sort(all.too_near.begin(), all.too_near.end());
  all.too_near.erase(std::unique(all.too_near.begin(), all.too_near.end()), all.too_near.end());
  return all;
}

/// What may be the highest round both places, for `nearby_`. Requires: not further apart than kNearShare of
/// the index's spacing.
void Envelope::look_near(std::array<double, 2> a, std::array<double, 2> b) {
  if (asked_ && asked_->holds(a[0], a[1]) && asked_->holds(b[0], b[1])) return;
  // What is asked next is mostly near.
  const double half = index_.spacing() / 2.0, x = (a[0] + b[0]) / 2.0, y = (a[1] + b[1]) / 2.0;
  asked_ = FlatBox{x - half, x + half, y - half, y + half};
  index_.near(*asked_, scratch_, nearby_);
}

void Envelope::count(std::size_t cost) {
  look_.count(cost, [this](std::size_t spent) {
    if (drops_.empty()) drops_ = index_.drops_after(spent, surface_);
    return !drops_.empty();
  });
}

template <class Look>
auto Envelope::look_at(double x, double y, Look look) {
  candidates_.clear();
  if (places_ == nullptr && !asks_tree()) look_near({x, y}, {x, y});
  Profile profile(*this, {x, y, 1.0, 0.0, 0.0});
  const auto found = look(profile);
  shut_by_ = profile.shut_by();
  return found;
}

std::optional<EnvelopePoint> Envelope::at(double x, double y) {
  return look_at(x, y, [](Profile& profile) -> std::optional<EnvelopePoint> {
    const Sample sample = profile.start();
    return sample.hit ? std::optional(sample.point) : std::nullopt;
  });
}

bool Envelope::rises_over(double x, double y, double z) {
  return look_at(x, y, [z](Profile& profile) { return profile.rises_over(z); });
}

}  // namespace tiltfeed::pathgen
