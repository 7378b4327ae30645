#include "pathgen/pattern/rough_layers.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pathgen/pattern/level_grid.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

namespace {

/// So far beyond the end of a pass the surface is taken to be gone, mm.
constexpr double kBeyondEnd = 1e-6;
constexpr int kMostFloorHalvings = 30;

/// (Z1) y' up to which, to both sides of 0, a floor lies in its own column.
double floor_limit(const Deformation& map, double floor) {
  const AxisFrame& frame = map.frame();
  if (frame.mode != AxisMode::kCircle) return std::numeric_limits<double>::infinity();
  const double cosine = (kLeastInColumn - frame.circle_radius) / std::abs(floor);
  return cosine > -1.0 ? map.scale_y() * std::acos(std::min(cosine, 1.0))
                       : std::numeric_limits<double>::infinity();
}

/// One line's passes, place by place along it.
class Layering {
 public:
  Layering(const FlatLine& line, const RoughLayer& layer, Heights& heights)
      : line_(line), layer_(layer), heights_(heights), map_(heights.map()) {
    const double limit = floor_limit(map_, layer.lower);
    if (!std::isfinite(limit) || line.dy == 0.0) return;
    const double turn = map_.period_y();
    for (const double y : {-limit - turn, limit - turn, -limit, limit, turn - limit, turn + limit})
      borders_.push_back((y - line.y) / line.dy);
    std::sort(borders_.begin(), borders_.end());
  }

  std::vector<Pass> run(const std::vector<Pass>& passes) {
    double end = 0.0;
    for (const Pass& pass : passes) {
      gap(end, run_of(pass.front()) - kBeyondEnd);
      for (const EnvelopePoint& p : pass) visit(p);
      end = run_of(pass.back()) + kBeyondEnd;
    }
    gap(end, line_.length);
    finish();
    return std::move(kept_);
  }

 private:
  double run_of(const EnvelopePoint& p) const {
    return (p.flat.x - line_.x) * line_.dx + (p.flat.y - line_.y) * line_.dy;
  }
  EnvelopePoint contact(double run) {
    EnvelopePoint p = heights_.contact({line_.x_at(run), line_.y_at(run)});
    p.flat.x = line_.x_at(run), p.flat.y = line_.y_at(run);
    return p;
  }

  /// Where there is no surface: the floor goes on, or the pass ends.
  void gap(double from, double to) {
    if (to - from <= 2.0 * kBeyondEnd) {
      if (from > 0.0) part();
      return;
    }
    const EnvelopePoint first = contact(from), last = contact(to), middle = contact((from + to) / 2.0);
    const bool open = layer_.over_gaps && first.flat.z == kNoSurface && last.flat.z == kNoSurface &&
                      middle.flat.z == kNoSurface;
    if (!open) return part();
    visit(first), visit(last);
  }

  /// What comes next does not go on from here.
  void part() {
    finish();
    has_last_ = false;
  }

  /// The next place of the line, with the places between where the floor leaves its column or comes back.
  void visit(const EnvelopePoint& p) {
    for (const double border : borders_) {
      if (!has_last_ || run_of(last_) >= border || border >= run_of(p)) continue;
      for (const double run : {border - kBeyondEnd, border + kBeyondEnd}) go_to(contact(run));
    }
    go_to(p);
  }

  /// The next place, with those between where a level is crossed.
  void go_to(const EnvelopePoint& p) {
    if (has_last_) {
      const bool up = p.flat.z > last_.flat.z;
      for (double level : {up ? layer_.lower : layer_.upper, up ? layer_.upper : layer_.lower})
        if ((last_.flat.z > level) != (p.flat.z > level)) meet(level, last_, p);
    }
    put(p);
    last_ = p, has_last_ = true;
  }

  void meet(double level, const EnvelopePoint& a, const EnvelopePoint& b) {
    const bool up = b.flat.z > level;
    double low = run_of(up ? a : b), high = run_of(up ? b : a);
    while (std::abs(high - low) > kTrimStep) {
      const double middle = (low + high) / 2.0;
      (contact(middle).flat.z > level ? high : low) = middle;
    }
    put(contact(up ? low : high));
    put(contact(up ? high : low));
  }

  void put(EnvelopePoint p) {
    if (p.flat.z > layer_.upper) return finish();
    const bool floor = p.flat.z <= layer_.lower;
    if (floor && !map_.in_column({p.flat.x, p.flat.y, layer_.lower}, kLeastInColumn)) return finish();
    if (floor) p = on_floor(p.flat, p.patch);
    if (floor && on_floor_ && !pass_.empty()) refine(pass_.back(), p, 0);
    pass_.push_back(p);
    on_floor_ = floor;
  }

  EnvelopePoint on_floor(Point<Flat> f, PatchId patch) const {
    const AxisLine line = map_.axis_line(f.x, f.y);
    return {{f.x, f.y, layer_.lower}, line.base + line.axis * layer_.lower, line.axis, line.axis, patch};
  }

  /// Points of the floor between two of them, until straight moves stay on it.
  void refine(const EnvelopePoint& a, const EnvelopePoint& b, int depth) {
    const EnvelopePoint middle = on_floor(lerp(a.flat, b.flat, 0.5), a.patch);
    const double off = distance(middle.centre, lerp(a.centre, b.centre, 0.5));
    if (depth == kMostFloorHalvings ||
        (off <= layer_.tolerance && length(cross(a.axis, b.axis)) <= layer_.max_axis_step &&
         dot(a.axis, b.axis) > 0.0))
      return;
    refine(a, middle, depth + 1);
    pass_.push_back(middle);
    refine(middle, b, depth + 1);
  }

  void finish() {
    if (pass_.size() > 1) kept_.push_back(std::move(pass_));
    pass_.clear();
    on_floor_ = false;
  }

  const FlatLine& line_;
  const RoughLayer& layer_;
  Heights& heights_;
  const Deformation& map_;
  std::vector<double> borders_;  ///< runs where the floor leaves its own column or enters it, rising
  EnvelopePoint last_;
  bool has_last_ = false, on_floor_ = false;
  Pass pass_;
  std::vector<Pass> kept_;
};

}  // namespace

std::vector<Pass> layer_passes(const std::vector<Pass>& passes, const FlatLine& line, const RoughLayer& layer,
                               Heights& heights) {
  return Layering(line, layer, heights).run(passes);
}

Result<Contours> rough_layers(const ClField& field, const std::vector<FlatLine>& lines, double stock_top,
                              bool over_gaps, const ContourOptions& options, const Progress& progress) {
  tbb::enumerable_thread_specific<Heights> heights([&] { return Heights(field, options.envelope); });
  std::vector<std::vector<Pass>> traced(lines.size());
  std::vector<double> lowest(lines.size(), kShut);
  constexpr std::size_t kLinesPerReport = 64;
  const auto each_line = [&](const char* stage, double done, double of, const auto& work) {
    for (std::size_t from = 0; from < lines.size(); from += kLinesPerReport) {
      const std::size_t to = std::min(from + kLinesPerReport, lines.size());
      tbb::parallel_for(from, to, work);
      const double share = static_cast<double>(to) / static_cast<double>(lines.size());
      if (progress && !progress(stage, (done + share) / of)) return false;
    }
    return true;
  };
  if (!each_line("lines", 0.0, 1.0, [&](std::size_t k) {
        traced[k] = heights.local().envelope().along(lines[k]).passes;
        for (const Pass& pass : traced[k])
          for (const EnvelopePoint& p : pass)
            if (in_polygon(options.boundary, p.flat.x, p.flat.y)) lowest[k] = std::min(lowest[k], p.flat.z);
      }))
    return cancelled();
  double bottom = options.height.low;
  if (!std::isfinite(bottom))
    bottom = lowest.empty() ? kShut : *std::min_element(lowest.begin(), lowest.end());
  if (!(bottom < stock_top))
    return fail(Code::kUnreachable, "no surface lies below the stock's top, z' = " +
                                        std::to_string(stock_top) + " mm: check the stock and containment");
  const auto levels = levels_between(stock_top, bottom, options.pattern.step_down);
  if (!levels) return tl::unexpected(levels.error());
  Contours result;
  double upper = stock_top, done = 0.0;
  result.floors.push_back(stock_top);
  for (const double lower : *levels) {
    const RoughLayer layer{upper, lower, options.envelope.tolerance, options.envelope.max_axis_step,
                           over_gaps};
    std::vector<std::vector<Pass>> groups(lines.size());
    if (!each_line("layers", done++, static_cast<double>(levels->size()), [&](std::size_t k) {
          groups[k] = inside_polygon(layer_passes(traced[k], lines[k], layer, heights.local()),
                                     field.deformation, options.boundary);
        }))
      return cancelled();
    for (auto& group : groups)
      if (!group.empty()) result.groups.push_back(std::move(group));
    upper = lower;
    result.floors.push_back(lower);
  }
  return result;
}

}  // namespace tiltfeed::pathgen
