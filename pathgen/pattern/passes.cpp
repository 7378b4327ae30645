#include "pathgen/pattern/passes.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "pathgen/envelope/pass_trim.h"
#include "pathgen/envelope/thinning.h"
#include "pathgen/options/side_step.h"
#include "pathgen/pattern/ridge_rows.h"
#include "pathgen/pattern/row_layout.h"
#include "pathgen/progress/stages.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/row_candidates.h"

namespace tiltfeed::pathgen {

void Passes::add(const Passes& other) {
  traced += other.traced, steep += other.steep;
  smoothed.add(other.smoothed);
  top = std::max(top, other.top);
  ridge = std::max(ridge, other.ridge);
  too_near.insert(too_near.end(), other.too_near.begin(), other.too_near.end());
  refusals.add(other.refusals);
}

void smooth(std::vector<Pass>& passes, double radius, const PointRules& rules, Envelope& envelope,
            Smoothed& report) {
  for (Pass& pass : passes) pass = smoothed(pass, {radius, envelope.options().tolerance}, envelope, report);
  leave_out(passes, [&](const EnvelopePoint& p) { return !rules.region().reaches(p.flat.z); });
}

namespace {

/// With StepMeasure::kRidge, tracing is this share of the work.
constexpr double kTraced = 0.4;
/// Rows between two calls of the progress function.
constexpr std::size_t kRowsPerReport = 64;
/// Meetings of rows and cells, about, that are kept at a time: some 50 MB.
constexpr double kMeetings = 2e6;
/// As many as this share of the index's cells must be met, or rows are looked up one by one.
constexpr double kWorth = 0.2;
/// A rectangle less than this share short of a whole turn goes all the way round: rounding.
constexpr double kWhole = 1e-9;

/// A stretch of a row whose neighbours must be `halvings` closer than the first raster's.
struct Need {
  double from = 0.0, to = 0.0;  ///< RowLayout::along
  int halvings = 0;
};

/// One piece of one row, to be traced.
struct Task {
  double row = 0.0;
  FlatLine line;
};

struct Traced {
  std::vector<Pass> passes;
  std::vector<PatchId> too_near;
  std::vector<Need> needs;
  std::uint64_t points = 0, steep = 0;
  double top = -std::numeric_limits<double>::infinity();
  RejectedPoints refusals;
  Smoothed smoothed;
};

class RasterTracer {
 public:
  RasterTracer(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
               double thinning, const std::function<bool(double)>& progress)
      : field_(field),
        options_(options),
        envelope_(envelope),
        thinning_(thinning),
        progress_(progress),
        rules_(options, field),
        wished_(asked_step(options)) {}

  Result<Passes> run() {
    const Pattern& pattern = options_.pattern;
    const bool flat = pattern.measure == StepMeasure::kFlat || pattern.measure == StepMeasure::kRidge;
    halvings_ = flat ? 0 : kMostHalvings;
    const auto raster = lay_rows(field_.index, rules_.region().within(field_.bounds), pattern,
                                 flat ? wished_ : kCoarse * wished_);
    if (!raster) return tl::unexpected(raster.error());
    raster_ = *raster;
    find_seams();
    if (pattern.measure == StepMeasure::kRidge) return widest();
    std::vector<Task> tasks;
    for (double k = 0.0; k < raster_.count; ++k) add_pieces(k, raster_.row(k), tasks);
    if (!trace(tasks, 0)) return cancelled();
    for (int depth = 1; depth <= halvings_; ++depth) {
      tasks = between(depth);
      if (tasks.empty()) break;
      if (!trace(tasks, depth)) return cancelled();
    }
    for (auto& [row, passes] : rows_) result_.rows.push_back(std::move(passes));
    return std::move(result_);
  }

 private:
  /// Rows of the first raster are this many side steps apart: where flat space is wider than the part, that
  /// is still near enough; elsewhere rows are put in between.
  static constexpr double kCoarse = 2.0;

  /// (R4) Of rows a share of the side step apart, those that are needed.
  Result<Passes> widest() {
    if (kRowsPerStep * raster_.count > kMaxRows || kRowsPerStep * raster_.crossings > kMaxCrossings)
      return fail(Code::kLimit, "pattern.measure ridge traces " + std::to_string(kRowsPerStep) +
                                    " rows a side step, which is more than memory is set aside for with a "
                                    "pattern.side_step_mm of " +
                                    std::to_string(options_.pattern.side_step) +
                                    "; use a larger step, or measure flat");
    std::vector<Task> tasks;
    const double pitch = 1.0 / kRowsPerStep;
    const std::size_t before = kRowsPerStep / 2 - 1;  // of the first stated row, half a step from the border
    const auto count = static_cast<std::size_t>(raster_.count - 1.0) * kRowsPerStep + 2 * before + 1;
    const auto number = [&](std::size_t k) {
      return (static_cast<double>(k) - static_cast<double>(before)) * pitch;
    };
    for (std::size_t k = 0; k < count; ++k) {
      rows_[number(k)];
      add_pieces(number(k), raster_.row(number(k)), tasks);
    }
    share_ = kTraced;
    if (!trace(tasks, 0)) return cancelled();
    std::vector<std::vector<Pass>> rows;
    for (auto& [row, passes] : rows_) rows.push_back(std::move(passes));
    auto chosen = widest_rows(rows, before, field_, options_, raster_, part_of(progress_, kTraced, 1.0));
    if (!chosen) return cancelled();
    result_.ridge = chosen->allowed;
    for (auto* part : {&chosen->main, &chosen->fill})
      for (std::vector<Pass>& row : *part) result_.rows.push_back(std::move(row));
    return std::move(result_);
  }

  void add_pieces(double row, const FlatLine& line, std::vector<Task>& tasks) const {
    for (const FlatLine& piece : rules_.region().inside(line)) tasks.push_back({row, piece});
  }

  bool trace(const std::vector<Task>& tasks, int depth) {
    std::vector<Traced> traced(tasks.size());
    tbb::enumerable_thread_specific<Envelope> envelopes(
        [&] { return Envelope(field_.surface, field_.deformation, field_.index, envelope_); });
    const std::size_t together = rows_together(tasks.size());
    RowCandidates met;
    const ReportShare report =
        part_of(progress_, share_ * depth / (halvings_ + 1), share_ * (depth + 1) / (halvings_ + 1));
    Watch watch(report, tasks.size());
    for (std::size_t from = 0; from < tasks.size(); from += kRowsPerReport) {
      const std::size_t to = std::min(from + kRowsPerReport, tasks.size());
      if (together > 0 && from % together == 0)
        met = RowCandidates(field_.index, lines_of(tasks, from, std::min(from + together, tasks.size())));
      tbb::parallel_for(from, to, [&](std::size_t k) {
        if (!watch.next()) return;
        Envelope& envelope = envelopes.local();
        const FlatLine& line = tasks[k].line;
        traced[k] = trace(together > 0 ? envelope.along(line, met, k % together) : envelope.along(line), line,
                          envelope);
      });
      if (watch.stopped()) return false;
    }
    for (std::size_t k = 0; k < tasks.size(); ++k) collect(tasks[k].row, traced[k]);
    return true;
  }

  void collect(double row, Traced& t) {
    result_.traced += t.points, result_.steep += t.steep;
    result_.top = std::max(result_.top, t.top);
    result_.too_near.insert(result_.too_near.end(), t.too_near.begin(), t.too_near.end());
    result_.refusals.add(t.refusals);
    result_.smoothed.add(t.smoothed);
    auto& passes = rows_[row];
    for (Pass& pass : t.passes) passes.push_back(std::move(pass));
    auto& needs = needs_[row];
    needs.insert(needs.end(), t.needs.begin(), t.needs.end());
  }

  /// For how many rows at a time their cells are found; 0 where a look at each cell of the index is not worth
  /// it.
  std::size_t rows_together(std::size_t rows) const {
    const double of_row = std::max(1.0, raster_.crossings / raster_.count);
    if (static_cast<double>(rows) * of_row < kWorth * static_cast<double>(field_.index.hulls())) return 0;
    return kRowsPerReport *
           static_cast<std::size_t>(std::ceil(kMeetings / (of_row * static_cast<double>(kRowsPerReport))));
  }

  static std::vector<FlatLine> lines_of(const std::vector<Task>& tasks, std::size_t from, std::size_t to) {
    std::vector<FlatLine> lines;
    for (std::size_t k = from; k < to; ++k) lines.push_back(tasks[k].line);
    return lines;
  }

  Traced trace(LineEnvelope found, const FlatLine& line, Envelope& envelope) const {
    Traced t;
    t.too_near = std::move(found.too_near);
    leave_held(found, line);
    for (const Pass& pass : found.passes) {
      t.points += pass.size();
      for (const EnvelopePoint& p : pass) {
        t.top = std::max(t.top, p.flat.z);
      }
      if (halvings_ > 0) find_needs(pass, t);
    }
    leave_out(found.passes, [&](const EnvelopePoint& p) { return !rules_.may_cut(p, t.refusals); });
    if (options_.smoothing > 0.0) smooth(found.passes, options_.smoothing, rules_, envelope, t.smoothed);
    for (const Pass& pass : found.passes)
      t.passes.push_back(
          spaced(thinned(pass, thinning_, envelope_), field_.deformation, envelope_.max_distance));
    return t;
  }

  /// (R1) How far apart two passes are on the surface at p for a step of 1 mm across them in flat space: the
  /// step in part space, lifted along the axis to stay on the tangent plane, without what runs along the
  /// pass.
  double stretch(const EnvelopePoint& p, bool& steep) const {
    const double facing = std::max(dot(p.normal, p.axis), kSteepestAcross);
    steep = facing > dot(p.normal, p.axis);
    const auto lifted = [&](Vec3 v) { return v - p.axis * (dot(p.normal, v) / facing); };
    // Rows meet the part below the CL reference: in a hollow further apart than there.
    const double contact = p.flat.z - field_.surface.pieces().front().corner * facing;
    double widest = 0.0;
    for (const double z : {p.flat.z, contact}) {
      const Deformation::Steps step = field_.deformation.steps({p.flat.x, p.flat.y, z});
      const Vec3 across = lifted(step.y * raster_.dx - step.x * raster_.dy);
      const Vec3 along = normalized(lifted(step.x * raster_.dx + step.y * raster_.dy));
      widest = std::max(widest, length(across - along * dot(across, along)));
    }
    return widest;
  }

  void find_needs(const Pass& pass, Traced& t) const {
    int last = -1;
    for (std::size_t i = 0; i < pass.size(); ++i) {
      bool steep = false;
      const double apart = stretch(pass[i], steep) * raster_.step;
      const int halvings =
          std::clamp(static_cast<int>(std::ceil(std::log2(apart / wished_) - 1e-9)), 0, halvings_);
      t.steep += steep && rules_.near_faces(pass[i]) ? 1 : 0;
      const double at = raster_.along(pass[i].flat.x, pass[i].flat.y);
      if (i > 0) {
        const int depth = std::max(last, halvings);
        const double from = raster_.along(pass[i - 1].flat.x, pass[i - 1].flat.y);
        if (!t.needs.empty() && t.needs.back().halvings == depth && t.needs.back().to == from) {
          t.needs.back().to = at;
        } else if (depth > 0) {
          t.needs.push_back({from, at, depth});
        }
      }
      last = halvings;
    }
  }

  /// (R3) Rows half way between those there are, where either neighbour needs it; stretches closer than a
  /// step are one, and each is a step longer at both ends, so that no place between two rows is missed.
  std::vector<Task> between(int depth) const {
    std::vector<Task> tasks;
    const double pitch = std::ldexp(1.0, -depth);
    const double last = raster_.count - (round_across_ && depth == 1 ? 0.0 : 0.5);
    for (double row = depth == 1 ? pitch : pitch - 0.5; row < last; row += 2.0 * pitch) {
      std::vector<std::pair<double, double>> runs;
      for (double beside : {row - pitch, row + pitch}) add_needs(beside, depth, runs);
      std::sort(runs.begin(), runs.end());
      const FlatLine whole = raster_.row(row);
      const double start = raster_.along(whole.x, whole.y);
      for (std::size_t i = 0; i < runs.size();) {
        double to = runs[i].second;
        std::size_t next = i + 1;
        for (; next < runs.size() && runs[next].first <= to + wished_; ++next)
          to = std::max(to, runs[next].second);
        const double from = std::max(runs[i].first - start, 0.0), end = std::min(to - start, whole.length);
        i = next;
        if (from >= end) continue;
        add_pieces(row,
                   {whole.dx == 0.0 ? whole.x : whole.x_at(from),
                    whole.dy == 0.0 ? whole.y : whole.y_at(from), whole.dx, whole.dy, end - from},
                   tasks);
      }
    }
    return tasks;
  }

  /// Stretches beside which the row needs another neighbour, past a seam also from its other side.
  void add_needs(double row, int depth, std::vector<std::pair<double, double>>& runs) const {
    if (round_across_) row -= raster_.count * std::ceil((row + 0.5) / raster_.count - 1.0);
    const auto found = needs_.find(row);
    if (found == needs_.end()) return;
    for (const Need& need : found->second) {
      if (need.halvings < depth) continue;
      for (const double turn : {-turn_along_, 0.0, turn_along_}) {
        runs.push_back({need.from - wished_ + turn, need.to + wished_ + turn});
        if (turn_along_ == 0.0) break;
      }
    }
  }

  /// Where the rectangle goes all the way round, its first row is the last one's neighbour, and the ends of
  /// rows are each other's.
  void find_seams() {
    const auto turn = [](double low, double high, double period) {
      return period > 0.0 && high - low > period * (1.0 - kWhole) ? period : 0.0;
    };
    const FlatBounds& b = raster_.bounds;
    const double x = turn(b.min_x, b.max_x, field_.deformation.period_x()),
                 y = turn(b.min_y, b.max_y, field_.deformation.period_y());
    if (raster_.dy == 0.0) turn_along_ = x, round_across_ = y > 0.0;
    if (raster_.dx == 0.0) turn_along_ = y, round_across_ = x > 0.0;
  }

  const ClField& field_;
  const PlanOptions& options_;
  EnvelopeOptions envelope_;
  double thinning_;
  const std::function<bool(double)>& progress_;
  PointRules rules_;
  double wished_;
  int halvings_ = 0;
  double share_ = 1.0;  ///< of the work, tracing
  RowLayout raster_;
  bool round_across_ = false;  ///< row -0.5 is row count - 0.5
  double turn_along_ = 0.0;    ///< where the rows go all the way round: how far that is; else 0
  std::map<double, std::vector<Pass>> rows_;  ///< by row number; exact, being sums of powers of two
  std::map<double, std::vector<Need>> needs_;
  Passes result_;
};

}  // namespace

Result<Passes> trace_raster(const ClField& field, const PlanOptions& options, const EnvelopeOptions& envelope,
                            double thinning, const std::function<bool(double)>& progress) {
  return RasterTracer(field, options, envelope, thinning, progress).run();
}

}  // namespace tiltfeed::pathgen
