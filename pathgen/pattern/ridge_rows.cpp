#include "pathgen/pattern/ridge_rows.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "pathgen/envelope/pass_trim.h"
#include "pathgen/options/side_step.h"
#include "pathgen/pattern/row_choice.h"

namespace tiltfeed::pathgen {

namespace {

constexpr double kNowhereNear = std::numeric_limits<double>::infinity();
constexpr double kNoSegment = -1.0;      ///< where the next node begins a pass
constexpr double kSurely = 1.0 - 1e-12;  ///< far more than rounding errors
/// A way leans over one surface less than this share of how it leans over the other.
constexpr double kFarMoreAlong = 0.5;
constexpr std::int32_t kRowsLookedAt = 40;  ///< rows on each side that are looked at

struct Node {
  double run = 0.0;  ///< along the rows
  Point<Part> centre, contact;
  float facing = 0.0f;  ///< 0: the ball does not touch there
  bool begins = false;  ///< a pass
};

/// From a node to the next.
struct Segment {
  Point<Part> from;
  Vec3 way;
  double square = kNoSegment;  ///< of its length

  double squared_distance(Point<Part> place) const {
    if (square == kNoSegment) return kNowhereNear;
    const Vec3 off = place - from;
    const double along = dot(off, way);
    // From its begin, its end, or square to it.
    if (along <= 0.0) return squared_length(off);
    if (along >= square) return squared_length(off - way);
    return squared_length(off) - along * along / square;
  }
};

/// A row, by bins along it.
struct RowTrack {
  std::vector<Node> nodes;
  std::vector<Segment> segments;  ///< behind each node
  std::int32_t first_bin = 0;
  std::vector<std::uint32_t> from;  ///< the first node of each bin, and one more
  std::uint32_t node_of(std::int32_t bin) const {
    const std::int32_t i = std::clamp(bin - first_bin, 0, static_cast<std::int32_t>(from.size()) - 1);
    return from[static_cast<std::size_t>(i)];
  }
};

class Ridges {
 public:
  Ridges(const std::vector<std::vector<Pass>>& rows, std::size_t first_stated, const ClField& field,
         const PlanOptions& options, const RowLayout& layout)
      : rows_(rows),
        stated_(static_cast<std::int32_t>(first_stated)),
        field_(field),
        options_(options),
        layout_(layout),
        rules_(options, field),
        radius_(field.surface.pieces().front().corner),
        bin_(std::min(layout.step, radius_ / 2.0)),
        together_(std::max(1, static_cast<std::int32_t>(radius_ / 4.0 / bin_))) {}

  /// Nothing where it was stopped.
  std::optional<RidgeRows> run(const ReportShare& report) {
    Watch watch(report, (options_.pattern.scallop > 0.0 ? 3 : 4) * rows_.size());
    tracks_.resize(rows_.size());
    each_row(watch, [&](std::size_t k) { tracks_[k] = track(rows_[k]); });
    RidgeRows found;
    found.allowed = allowed(watch);
    std::vector<ChoosableRow> choosable(rows_.size());
    each_row(watch, [&](std::size_t k) {
      choosable[k] = choosable_row(static_cast<std::int32_t>(k), found.allowed);
    });
    const ChosenRows chosen =
        choose_rows(choosable, way_up(), bin_ * together_, [&] { return watch.next(); });
    if (watch.stopped()) return std::nullopt;
    found.main = cut(chosen.main), found.fill = cut(chosen.fill);
    return found;
  }

 private:
  template <class Visit>
  void each_row(Watch& watch, const Visit& visit) const {
    tbb::parallel_for(std::size_t{0}, rows_.size(), [&](std::size_t k) {
      if (watch.next()) visit(k);
    });
  }

  std::int32_t bin_of(double run) const { return static_cast<std::int32_t>(std::floor(run / bin_)); }
  /// That of so many together by which rows are chosen.
  std::int32_t wide_bin(std::int32_t bin) const {
    return bin >= 0 ? bin / together_ : -((together_ - 1 - bin) / together_);
  }

  RowTrack track(const std::vector<Pass>& passes) const {
    RowTrack t;
    for (const Pass& pass : passes)
      for (std::size_t i = 0; i < pass.size(); ++i) {
        const EnvelopePoint& p = pass[i];
        const ToolPiece& piece = rules_.touching(p);
        // Where shank or holder raise the ball, rows go as near as they do along its lowest points.
        const bool touches = piece.part == ToolPart::kCutter && !piece.at_fixtures;
        const Vec3 to = touches ? p.normal : p.axis;
        t.nodes.push_back({layout_.along(p.flat.x, p.flat.y), p.centre, p.centre - to * radius_,
                           touches ? static_cast<float>(dot(p.normal, p.axis)) : 0.0f, i == 0});
      }
    if (t.nodes.empty()) return t;
    t.segments.resize(t.nodes.size());
    for (std::size_t i = 0; i + 1 < t.nodes.size(); ++i) {
      const Vec3 way = t.nodes[i + 1].centre - t.nodes[i].centre;
      t.segments[i] = {t.nodes[i].centre, way, t.nodes[i + 1].begins ? kNoSegment : squared_length(way)};
    }
    t.first_bin = bin_of(t.nodes.front().run);
    const std::int32_t last = bin_of(t.nodes.back().run);
    t.from.resize(static_cast<std::size_t>(last - t.first_bin) + 2,
                  static_cast<std::uint32_t>(t.nodes.size()));
    for (std::size_t i = t.nodes.size(); i-- > 0;)
      t.from[static_cast<std::size_t>(std::max(0, bin_of(t.nodes[i].run) - t.first_bin))] =
          static_cast<std::uint32_t>(i);
    for (std::size_t b = t.from.size() - 1; b-- > 0;) t.from[b] = std::min(t.from[b], t.from[b + 1]);
    return t;
  }

  /// How far aside of its pass a row leaves a place near a run coordinate: the ridge is what a ball leaves so
  /// far aside on a plane.
  double aside(Point<Part> place, std::int32_t bin, std::int32_t row) const {
    double least = kNowhereNear;
    for (const Segment& s : near(bin, row)) least = std::min(least, s.squared_distance(place));
    return std::sqrt(std::max(0.0, least - radius_ * radius_));
  }
  /// Is it surely no more than `most`? Asked of rows well within that: the segment in the middle, or one
  /// beside it, mostly tells.
  bool surely_aside(Point<Part> place, std::int32_t bin, std::int32_t row, double most) const {
    if (most <= 0.0) return false;
    const double enough = kSurely * (radius_ * radius_ + most * most);
    const std::span<const Segment> all = near(bin, row);
    const std::size_t middle = all.size() / 2;
    for (std::size_t i = middle; i < all.size(); ++i)
      if (all[i].squared_distance(place) <= enough) return true;
    for (std::size_t i = middle; i-- > 0;)
      if (all[i].squared_distance(place) <= enough) return true;
    return false;
  }
  /// The segments of a row near a run coordinate.
  std::span<const Segment> near(std::int32_t bin, std::int32_t row) const {
    const RowTrack& t = tracks_[static_cast<std::size_t>(row)];
    if (t.segments.empty()) return {};
    const std::size_t from = std::max(t.node_of(bin - 1), std::uint32_t{1}) - 1,
                      to = std::min<std::size_t>(t.node_of(bin + 2) + 1, t.segments.size() - 1);
    return from < to ? std::span(t.segments).subspan(from, to - from) : std::span<const Segment>();
  }
  double left(double aside) const { return std::hypot(radius_, aside) - radius_; }

  /// How far aside of rows near one of them a place lies, each found once.
  class Asides {
   public:
    Asides(const Ridges& ridges, Point<Part> place, std::int32_t bin, std::int32_t row)
        : ridges_(ridges), place_(place), bin_(bin), first_(row - kRowsLookedAt) {
      known_.fill(kUnknown);
    }
    /// Requires: a row at most kRowsLookedAt away.
    double of(std::int32_t row) {
      double& known = known_[static_cast<std::size_t>(row - first_)];
      if (known == kUnknown) known = ridges_.aside(place_, bin_, row);
      return known;
    }
    /// Likewise; 0 where it is surely no more than `most`, which is quicker told.
    double of(std::int32_t row, double most) {
      const double known = known_[static_cast<std::size_t>(row - first_)];
      return known == kUnknown && ridges_.surely_aside(place_, bin_, row, most) ? 0.0 : of(row);
    }

   private:
    static constexpr double kUnknown = -1.0;
    const Ridges& ridges_;
    const Point<Part> place_;
    const std::int32_t bin_, first_;
    std::array<double, 2 * kRowsLookedAt + 1> known_;
  };

  /// Where the ball touches between two nodes.
  struct Touched {
    Point<Part> from, to;
    float facing = 0.0f;
  };
  /// It rolls on along the surface at one node until it meets that at the other, if the way is far more along
  /// that one. Else its contact goes from the one to the other.
  Touched touched(const Node& a, const Node& b) const {
    const Vec3 way = b.centre - a.centre;
    const auto lean = [&](const Node& node) { return std::abs(dot(way, node.centre - node.contact)); };
    const Node &rolls = lean(a) <= lean(b) ? a : b, &meets = lean(a) <= lean(b) ? b : a;
    if (lean(rolls) >= kFarMoreAlong * lean(meets))
      return {a.contact, b.contact, std::min(a.facing, b.facing)};
    const Vec3 off = rolls.contact - rolls.centre;
    return {a.centre + off, b.centre + off, rolls.facing};
  }

  /// Calls visit(place, bin, facing) at most a bin apart along a row.
  template <class Visit>
  void each_place(std::int32_t row, const Visit& visit) const {
    const std::vector<Node>& nodes = tracks_[static_cast<std::size_t>(row)].nodes;
    double due = 0.0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (i == 0 || nodes[i].begins) {
        due = 0.0;
        continue;
      }
      const Node &a = nodes[i - 1], &b = nodes[i];
      const Touched on = touched(a, b);
      const double way = distance(on.from, on.to);
      for (; due < way; due += bin_) {
        const double f = due / way;
        visit(lerp(on.from, on.to, f), bin_of(a.run + (b.run - a.run) * f), static_cast<double>(on.facing));
      }
      due -= way;
    }
  }

  /// How far aside of the raster's own rows the place at a row lies, of those up to that row and of those
  /// beyond; infinite where none comes near.
  struct Stated {
    double up_to = kNowhereNear, beyond = kNowhereNear;
    double least(double half = 0.0) const { return std::min(up_to + half, beyond - half); }
  };
  Stated aside_of_stated(Asides& asides, std::int32_t row) const {
    Stated stated;
    const std::int32_t below =
        (row - stated_) - ((row - stated_) % kRowsPerStep + kRowsPerStep) % kRowsPerStep;
    for (std::int32_t k = -1; k <= 2; ++k) {
      const std::int32_t at = stated_ + below + k * kRowsPerStep;
      if (at < 0 || at >= static_cast<std::int32_t>(rows_.size())) continue;
      double& least = at <= row ? stated.up_to : stated.beyond;
      least = std::min(least, asides.of(at));
    }
    return stated;
  }

  /// A place of a row, and how much of the surface it stands for.
  struct Sample {
    float aside = 0.0f;  ///< of the raster's own rows
    float width = 0.0f;  ///< of the surface to the next row, mm
  };

  /// What the job says, or what the raster's own rows leave on kRidgeShare of the surface; no more than
  /// asked_most().
  double allowed(Watch& watch) const {
    if (options_.pattern.scallop > 0.0) return std::min(asked_most(), options_.pattern.scallop);
    std::vector<std::vector<Sample>> by_row(rows_.size());
    each_row(watch, [&](std::size_t k) {
      each_place(static_cast<std::int32_t>(k), [&](Point<Part> place, std::int32_t bin, double facing) {
        if (facing < kSteepestAcross) return;
        const auto row = static_cast<std::int32_t>(k);
        Asides asides(*this, place, bin, row);
        const double aside = aside_of_stated(asides, row).least();
        if (aside < kNowhereNear)
          by_row[k].push_back({static_cast<float>(aside), static_cast<float>(width(asides, row, facing))});
      });
    });
    std::vector<Sample> all;
    for (const auto& row : by_row) all.insert(all.end(), row.begin(), row.end());
    if (all.empty()) return 0.0;
    tbb::parallel_sort(all.begin(), all.end(), [](Sample a, Sample b) {
      return std::pair(a.aside, a.width) < std::pair(b.aside, b.width);
    });
    const auto add = [](double sum, Sample s) { return sum + static_cast<double>(s.width); };
    double over = (1.0 - kRidgeShare) * std::accumulate(all.begin(), all.end(), 0.0, add);
    std::size_t last = all.size() - 1;
    while (last > 0 && (over -= static_cast<double>(all[last].width)) > 0.0) --last;
    return std::min(asked_most(), left(static_cast<double>(all[last].aside)));
  }
  /// Of the surface from a place of a row to the next row; no more than on a plane that leans so far over.
  double width(Asides& asides, std::int32_t row, double facing) const {
    const bool is_last = row + 1 == static_cast<std::int32_t>(rows_.size());
    const double to_next = is_last ? kNowhereNear : asides.of(row + 1),
                 to_last = row == 0 ? kNowhereNear : asides.of(row - 1);
    return std::min({to_next, to_last, layout_.step / kRowsPerStep / facing});
  }
  double asked_most() const {
    const double radius = options_.cutter.radius(), half = std::min(options_.pattern.side_step / 2.0, radius);
    return std::min(radius,
                    4.0 * (radius - std::sqrt(radius * radius - half * half)) + options_.tolerance / 2.0);
  }

  ChoosableRow choosable_row(std::int32_t row, double allowed) const {
    ChoosableRow r;
    const RowTrack& t = tracks_[static_cast<std::size_t>(row)];
    if (t.nodes.empty()) return r;
    measure(t, r);
    const double wide = std::sqrt((radius_ + allowed) * (radius_ + allowed) - radius_ * radius_);
    const auto count = static_cast<std::int32_t>(rows_.size());
    std::vector<double> below, beyond;  // how far aside of the rows before and after
    each_place(row, [&](Point<Part> place, std::int32_t bin, double) {
      Asides asides(*this, place, bin, row);
      const Stated stated = aside_of_stated(asides, row);
      if (stated.least() == kNowhereNear) return;
      const double to_next = row + 1 < count ? asides.of(row + 1) : 0.0;
      const double to_last = row > 0 ? asides.of(row - 1) : 0.0;
      // The place itself, and how much further along the surface there are others.
      std::array<double, 3> shifts{};
      std::size_t shifted = 1;
      const auto look = [&](double shift) {
        if (std::abs(shift) < kNowhereNear) shifts[shifted++] = shift;
      };
      if (row + 1 < count) look(0.5 * to_next);  // half way to the next row
      if (row == 0) look(-to_next);              // the borders are one row further
      if (row > 0 && row + 1 == count) look(to_last);
      // Rows that are so near are near enough for all of them.
      std::array<double, 3> limits{};
      double farthest = 0.0, near_below = kNowhereNear, near_beyond = kNowhereNear;
      for (std::size_t i = 0; i < shifted; ++i) {
        const double limit = limits[i] = std::max(wide, stated.least(shifts[i]));
        farthest = std::max(farthest, limit + std::abs(shifts[i]));
        if (std::abs(shifts[i]) > limit) continue;
        near_below = std::min(near_below, limit - shifts[i]);
        near_beyond = std::min(near_beyond, limit + shifts[i]);
      }
      below.clear(), beyond.clear();
      for (std::int32_t k = row - 1; k >= std::max(0, row - kRowsLookedAt); --k)
        if (below.push_back(asides.of(k, near_below)); below.back() > farthest) break;
      for (std::int32_t k = row + 1; k < std::min(count, row + kRowsLookedAt + 1); ++k)
        if (beyond.push_back(asides.of(k, near_beyond)); beyond.back() > farthest) break;
      for (std::size_t i = 0; i < shifted; ++i) {
        const double limit = limits[i];
        if (std::abs(shifts[i]) > limit) continue;
        RowNeed need{wide_bin(bin), row, row};
        for (const double off : below) {
          if (off + shifts[i] > limit) break;
          --need.low;
        }
        for (const double off : beyond) {
          if (off - shifts[i] > limit) break;
          ++need.high;
        }
        add(need, r.needs);
      }
    });
    return r;
  }

  /// Without those of the same bin that another holds already.
  static void add(const RowNeed& need, std::vector<RowNeed>& needs) {
    std::size_t first = needs.size();
    while (first > 0 && needs[first - 1].bin == need.bin) --first;
    const auto holds = [](const RowNeed& a, const RowNeed& b) { return a.low >= b.low && a.high <= b.high; };
    for (std::size_t i = first; i < needs.size(); ++i)
      if (holds(needs[i], need)) return;
    needs.erase(std::remove_if(needs.begin() + static_cast<std::ptrdiff_t>(first), needs.end(),
                               [&](const RowNeed& other) { return holds(need, other); }),
                needs.end());
    needs.push_back(need);
  }

  void measure(const RowTrack& t, ChoosableRow& r) const {
    r.first_bin = wide_bin(t.first_bin);
    const std::int32_t last = wide_bin(t.first_bin + static_cast<std::int32_t>(t.from.size()) - 2);
    r.way.assign(static_cast<std::size_t>(last - r.first_bin) + 1, 0.0f);
    for (std::size_t i = 0; i < t.nodes.size(); ++i) {
      const std::int32_t bin = wide_bin(bin_of(t.nodes[i].run));
      if (t.nodes[i].begins) {
        r.passes.push_back({bin, bin});
        continue;
      }
      r.passes.back().last = std::max(r.passes.back().last, bin);
      const Node &a = t.nodes[i - 1], &b = t.nodes[i];
      const std::int32_t first = wide_bin(bin_of(a.run));
      const double way = distance(a.centre, b.centre);
      for (std::int32_t k = first; k <= bin; ++k)
        r.way[static_cast<std::size_t>(std::max(0, k - r.first_bin))] +=
            static_cast<float>(way / (bin - first + 1));
    }
    for (std::size_t k = 1; k < r.way.size(); ++k) r.way[k] += r.way[k - 1];
  }

  /// A way up, over and down, as mm cut in that time.
  double way_up() const {
    const RapidRates::Axis& axis = options_.links.rapid.linear;
    const auto rapid = [&](double way) {
      if (way * axis.acceleration >= axis.velocity * axis.velocity)
        return way / axis.velocity + axis.velocity / axis.acceleration;
      return 2.0 * std::sqrt(way / axis.acceleration);
    };
    double top = -kNowhereNear, sum = 0.0, count = 0.0;
    for (const auto& row : rows_)
      for (const Pass& pass : row)
        for (const EnvelopePoint& p : pass) top = std::max(top, p.flat.z), sum += p.flat.z, ++count;
    const double up = options_.links.clearance + (count > 0.0 ? top - sum / count : 0.0);
    const double seconds = 3.0 * rapid(up) + 1.5 * options_.links.approach / options_.plunge_feed.mm_per_s();
    return seconds * options_.cut_feed.mm_per_s();
  }

  std::vector<std::vector<Pass>> cut(const std::vector<RowStretch>& stretches) const {
    std::vector<std::vector<Pass>> passes;
    std::int32_t last = -1;
    for (std::size_t i = 0; i < stretches.size(); ++i) {
      const RowStretch& s = stretches[i];
      if (s.row != last) passes.emplace_back();
      last = s.row;
      const double from = (s.first * together_ - 2) * bin_, to = ((s.last + 1) * together_ + 2) * bin_;
      for (const Pass& pass : rows_[static_cast<std::size_t>(s.row)]) cut(pass, from, to, passes.back());
    }
    std::erase_if(passes, [](const auto& row) { return row.empty(); });
    return passes;
  }

  void cut(const Pass& pass, double from, double to, std::vector<Pass>& pieces) const {
    const auto run = [&](const EnvelopePoint& p) { return layout_.along(p.flat.x, p.flat.y); };
    if (run(pass.back()) <= from || run(pass.front()) >= to) return;
    if (run(pass.front()) >= from && run(pass.back()) <= to) return pieces.push_back(pass);
    const std::vector<Pass> kept = keep_where(
        {pass}, field_.deformation, [&](const EnvelopePoint& p) { return run(p) >= from && run(p) <= to; },
        0.0);
    pieces.insert(pieces.end(), kept.begin(), kept.end());
  }

  const std::vector<std::vector<Pass>>& rows_;
  const std::int32_t stated_;
  const ClField& field_;
  const PlanOptions& options_;
  const RowLayout& layout_;
  const PointRules rules_;
  const double radius_, bin_;
  const std::int32_t together_;
  std::vector<RowTrack> tracks_;
};

}  // namespace

std::optional<RidgeRows> widest_rows(const std::vector<std::vector<Pass>>& rows, std::size_t first_stated,
                                     const ClField& field, const PlanOptions& options,
                                     const RowLayout& layout, const ReportShare& report) {
  return Ridges(rows, first_stated, field, options, layout).run(report);
}

}  // namespace tiltfeed::pathgen
