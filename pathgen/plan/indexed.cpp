#include "pathgen/plan/indexed.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <optional>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/axis/direction_grid.h"
#include "pathgen/indexed/index_candidates.h"
#include "pathgen/indexed/index_order.h"
#include "pathgen/indexed/indexed_cells.h"
#include "pathgen/indexed/indexed_regions.h"
#include "pathgen/indexed/set_cover.h"
#include "pathgen/options/side_step.h"
#include "pathgen/plan/predefined_axis.h"
#include "pathgen/plan/rejected_points.h"
#include "pathgen/plan/rest_of_cells.h"
#include "pathgen/plan/rest_wanted.h"
#include "pathgen/plan/stock_before.h"
#include "pathgen/progress/shares.h"
#include "pathgen/progress/stages.h"
#include "pathgen/tool/blank_solid.h"

namespace tiltfeed::pathgen {

namespace {

/// Places on the surface by which directions are chosen.
constexpr std::uint32_t kSamples = 2000;
/// What no candidate reaches is asked about in directions 8 degrees apart.
constexpr int kEverywhereLevel = 3;
/// Cells per diagonal of the part's box.
constexpr double kCellsAcross = 100.0;
/// Largest turn of the axis in one move between two directions.
const Angle kTurnStep = Angle::from_degrees(10.0);

std::string text_of(Vec3 d) {
  const auto tidy = [](double v) { return number_text(std::abs(v) < 5e-5 ? 0.0 : v); };
  return "(" + tidy(d.x) + ", " + tidy(d.y) + ", " + tidy(d.z) + ")";
}

std::string percent_text(double share) { return number_text(std::round(share * 1e4) / 100.0) + " %"; }

AxisFrame frame_of(Vec3 direction, Vec3 up) {
  AxisFrame frame;
  Vec3 level = cross(up, direction);
  if (length(level) < 1e-6) level = cross(std::abs(up.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, up);
  frame.n = direction;
  frame.t = normalized(level - direction * dot(level, direction));
  return frame;
}

/// The story of one plan.
class Indexed {
 public:
  Indexed(const CheckedMesh& part, const PlanOptions& options, const Progress& progress)
      : part_(part), options_(options), stages_(progress, plan_.report.times) {
    middle_ = lerp(part.bounds.min, part.bounds.max, 0.5);
    for (const Point<Part> v : part.mesh.vertices) radius_ = std::max(radius_, distance(v, middle_));
    part_radius_ = radius_;
    // The tool stands off the sphere by its stock, too.
    radius_ += options.allowance + options.axial_stock;
    if (options.fixtures)
      for (const Point<Part> v : options.fixtures->mesh.vertices)
        radius_ = std::max(radius_, distance(v, middle_) + options.fixture_room.cutter);
    if (options.blank)
      for (const Point<Part> v : options.blank->mesh().vertices)
        radius_ = std::max(radius_, distance(v, middle_));
    if (options.blank) blank_.emplace(part, options);
    plan_.report.facets = part.mesh.facets.size();
    plan_.report.warnings = part.warnings;
  }

  Result<Plan> run() {
    if (!stages_.begin("directions")) return cancelled();
    const FacetBvh tree(part_.mesh);
    const SweptTool tool(tree, options_, ToleranceBudget(options_.tolerance).touch());
    const CellReach reach(tool, options_);
    const double size = std::max(2.0 * part_radius_ / kCellsAcross, options_.tolerance);
    const std::vector<SurfaceCell> cells = make_cells(part_.mesh, size);
    if (options_.rest_more_than > 0.0) {
      auto rest = RestWanted::find(part_, options_, part_of(share_, 0.0, 0.1));
      if (!rest) return tl::unexpected(rest.error());
      rest_.emplace(std::move(*rest));
      plan_.report.rest = rest_->before();
    }
    if (auto done = choose(reach, sample_cells(only_chosen(cells, options_), kSamples)); !done)
      return tl::unexpected(done.error());
    if (stages_.stopped() || !share_(0.6)) return cancelled();
    const IndexedRegions regions(cells, size, chosen_,
                                 reach_sets(reach, cells, chosen_, part_of(share_, 0.6, 1.0)),
                                 2.0 * std::max(asked_step(options_), options_.pattern.step_down));
    if (stages_.stopped()) return cancelled();
    if (auto done = cut_all(regions, reach); !done) return tl::unexpected(done.error());
    if (plan_.path.moves.empty())
      return fail(Code::kUnreachable, "no direction leaves anything to cut: check containment and guards");
    if (options_.find_rest_material) {
      if (!stages_.begin("uncut")) return cancelled();
      plan_.report.between = find_rest_of_cells(part_, options_, tool, chosen_, plan_.path.moves, share_);
      if (stages_.stopped()) return cancelled();
      stages_.end();
      warn_between(*plan_.report.between, "use a smaller pattern.side_step_mm", plan_.report);
    }
    return std::move(plan_);
  }

 private:
  /// The directions, in the order of machining.
  Result<void> choose(const CellReach& reach, const std::vector<SurfaceCell>& samples) {
    const IndexCandidates all = index_candidates(part_, options_, reach, samples, part_of(share_, 0.0, 0.4));
    if (stages_.stopped()) return cancelled();
    const IndexedAxis& how = options_.indexed;
    const SetCover cover = cover_by_few(all.sets, how.coverage, how.most_directions, how.least_gain);
    tell_unreached(reach, samples, all, cover);
    if (cover.chosen.empty())
      return fail(Code::kUnreachable,
                  "the tool reaches the part from no direction within setup.tilt_max_deg and "
                  "axis.steepest_deg; use a smaller or longer cutter");
    std::vector<Vec3> chosen;
    for (const std::uint32_t c : cover.chosen) chosen.push_back(all.directions[c]);
    std::vector<std::uint32_t> order;
    for (const std::uint32_t i : order_by_travel(chosen, options_.up))
      chosen_.push_back(chosen[i]), order.push_back(cover.chosen[i]);
    tell_chosen(all, order, samples.size());
    return {};
  }

  /// What the chosen candidates, in the order of machining, reach of the samples.
  void tell_chosen(const IndexCandidates& all, const std::vector<std::uint32_t>& order, std::size_t samples) {
    IndexedReport& report = plan_.report.indexed.emplace();
    const double share = 1.0 / static_cast<double>(samples);
    for (const Vec3 axis : chosen_) report.directions.push_back({axis, 0.0});
    for (std::size_t c = 0; c < samples; ++c) {
      if (all.reach(c)) report.reachable += share;
      std::size_t by = 0, last = 0;
      for (std::size_t i = 0; i < order.size(); ++i)
        if (all.sets[order[i]][c] != 0) ++by, last = i;
      if (by > 0) report.reached += share;
      if (by == 1) report.directions[last].alone += share;
    }
  }

  /// (I1) What of the surface is not reached, and why.
  void tell_unreached(const CellReach& reach, const std::vector<SurfaceCell>& samples,
                      const IndexCandidates& all, const SetCover& cover) {
    const DirectionGrid grid(kEverywhereLevel);
    const std::vector<Vec3>& everywhere = grid.directions();
    std::array<double, 7> lost{};  // too wide, cutter, shank, holder, fixture, tilt, not chosen
    std::array<std::uint32_t, 7> first{};
    double whole = 0.0;
    const ReportShare report = part_of(share_, 0.4, 0.6);
    Watch watch(report, samples.size());
    for (std::size_t c = 0; c < samples.size() && watch.next(); ++c) {
      whole += samples[c].area;
      const auto in = [&](std::uint32_t s) { return all.sets[s][c] != 0; };
      if (std::any_of(cover.chosen.begin(), cover.chosen.end(), in)) continue;
      std::size_t why = 0;
      if (all.reach(c)) {
        why = 6;
      } else if (reach.seats(samples[c])) {
        for (why = 1; why < 5; ++why) {
          std::uint32_t hint = kNoFacet;
          if (std::none_of(everywhere.begin(), everywhere.end(),
                           [&](Vec3 d) { return reach.clears(samples[c], d, hint, static_cast<int>(why)); }))
            break;
        }
      }
      if (why == 4)
        note_fixture(options_, reach.tool(), samples[c].place, samples[c].normal, plan_.report).area +=
            samples[c].area;
      if (lost[why] == 0.0) first[why] = samples[c].source;
      lost[why] += samples[c].area;
    }
    const std::array<std::string, 7> why_text{
        "the cutter's end does not fit there; use a smaller one",
        "the cutter hits the part from every direction; use a thinner one, or a larger axis.steepest_deg",
        std::string("the shank hits the part from every direction; ") + remedy(RestReason::kShank),
        std::string("the holder hits the part from every direction; ") + remedy(RestReason::kHolder),
        "in every direction that is clear of the part a fixture is in the way; "
        "clamp the part elsewhere, or use a longer or thinner tool",
        std::string("the tool axis would tilt further than setup.tilt_max_deg; ") + remedy(RestReason::kTilt),
        "the directions chosen do not reach it, others do; raise axis.most_directions or "
        "axis.coverage_percent, lower axis.least_gain_percent, or use the mode free"};
    for (std::size_t why = 0; why < lost.size(); ++why)
      if (lost[why] > 0.0)
        plan_.report.warnings.push_back(percent_text(lost[why] / whole) + " of the " +
                                        (options_.only_faces ? "chosen faces" : "surface") +
                                        " is left, the first at facet " + std::to_string(first[why]) + ": " +
                                        why_text[why]);
    warn_fixtures("", plan_.report);
  }

  /// The paths of all directions, as many at a time as there are cores, put together in their order.
  Result<void> cut_all(const IndexedRegions& regions, const CellReach& reach) {
    if (!stages_.begin("passes")) return cancelled();
    std::vector<std::optional<Result<Plan>>> parts(chosen_.size());
    Shares shares(chosen_.size());
    // Only the caller's thread may tell and be told.
    auto all = std::async(std::launch::async, [&] {
      const Shares::End end(shares);
      tbb::parallel_for(std::size_t{0}, chosen_.size(), [&](std::size_t d) {
        const Progress progress = [&](const char* stage, double f) { return shares.tell(d, stage, f); };
        if (regions.area(d) > 0.0 && shares.tell(d, "", 0.0)) parts[d] = cut(d, regions, reach, progress);
        shares.tell(d, "", 1.0);
      });
    });
    bool stopped = false;
    while (const auto share = shares.next())
      if (!stopped && !stages_.report(*share)) stopped = true, shares.stop();
    all.get();
    if (stopped) return cancelled();
    for (std::size_t d = 0; d < chosen_.size(); ++d) {
      if (!parts[d]) continue;
      Result<Plan>& part = *parts[d];
      const std::string name = "direction " + std::to_string(d + 1) + " of " +
                               std::to_string(chosen_.size()) + ", " + text_of(chosen_[d]) + ": ";
      if (part) {
        add(std::move(*part), chosen_[d], name);
      } else if (part.error().code == Code::kUnreachable) {
        plan_.report.warnings.push_back(name + part.error().message);
      } else {
        return tl::unexpected(part.error());
      }
    }
    stages_.end();
    return {};
  }

  Result<Plan> cut(std::size_t d, const IndexedRegions& regions, const CellReach& reach,
                   const Progress& progress) const {
    PlanOptions options = options_;
    options.axis = frame_of(chosen_[d], options_.up);
    options.containment = {};
    const double gap =
        ToleranceBudget(options_.tolerance).half_thinned() + options_.radial_stock + options_.axial_stock;
    // Where the side of the tool runs down past an overhang its end touches nothing, and that is not wanted.
    const auto wanted = [&](const EnvelopePoint& p) {
      const Containment& in = options_.containment;
      if (!in.first.contains(p.centre.x) || !in.second.contains(p.centre.y) ||
          !in.height.contains(p.centre.z))
        return false;
      if (rest_ && !rest_->wants(p.centre, chosen_[d])) return false;
      const auto contact = reach.contact(p.centre, gap);
      return contact && regions.wants(d, contact->place, contact->facet);
    };
    const auto straight = [&](const EnvelopePoint& a, const EnvelopePoint& b) {
      return reach.contact(a.centre, gap) && reach.contact(lerp(a.centre, b.centre, 0.5), gap) &&
             reach.contact(b.centre, gap);
    };
    WantedPart asked{
        .place = wanted, .straight = straight, .spacing = regions.spacing(), .overlap = asked_step(options_)};
    const StockBefore* stock = rest_ ? &rest_->stock() : blank_ ? &*blank_ : nullptr;
    if (stock != nullptr && stock->known())
      asked.free_from = [stock](const Deformation& map, Point<Flat> place, double from, double to) {
        return stock->free_from(map, place, from, to);
      };
    return plan_where(part_, options, &asked, progress);
  }

  /// The axis is put back to the last digit: cutting passes rounds it.
  void add(Plan&& part, Vec3 axis, const std::string& name) {
    PlanReport& all = plan_.report;
    const PlanReport& one = part.report;
    all.passes += one.passes, all.slice_points += one.slice_points, all.points += one.points;
    all.retracts += one.retracts, all.joins += one.joins;
    all.cut_length += one.cut_length, all.rapid_length += one.rapid_length;
    for (std::size_t w = part_.warnings.size(); w < one.warnings.size(); ++w)
      all.warnings.push_back(name + one.warnings[w]);
    for (Move& move : part.path.moves) move.pose.axis = axis;
    if (plan_.path.moves.empty()) {
      plan_.path = std::move(part.path);
      return;
    }
    turn_to(part.path.moves.front().pose);
    plan_.path.moves.insert(plan_.path.moves.end(), part.path.moves.begin(), part.path.moves.end());
  }

  /// (I4) From the end of one direction's path, above all of the part as that direction sees it, to a place
  /// beyond the sphere; round the sphere; and to the start of the next path.
  void turn_to(const Pose& next) {
    const double beyond = radius_ + options_.links.clearance;
    // Half way through a turn by `step` the tip is nearer to the middle by its arrow; half the clearance.
    const double step = 2.0 * std::acos(1.0 - 0.5 * options_.links.clearance / beyond);
    const Vec3 from = plan_.path.moves.back().pose.axis;
    for (const Vec3 axis :
         turns_between(from, next.axis, options_.up, std::min(kTurnStep, Angle::from_radians(step)))) {
      const Pose pose{middle_ + axis * beyond, axis};
      plan_.report.rapid_length += distance(plan_.path.moves.back().pose.tip, pose.tip);
      plan_.path.moves.push_back({pose, MoveKind::kRapid});
    }
    plan_.report.rapid_length += distance(plan_.path.moves.back().pose.tip, next.tip);
  }

  const CheckedMesh& part_;
  const PlanOptions& options_;
  Point<Part> middle_;
  double part_radius_ = 0.0;  ///< of the sphere about the middle that holds the part, mm
  double radius_ = 0.0;       ///< of that which holds the part with its stock and the fixtures, mm
  std::vector<Vec3> chosen_;  ///< in the order of machining
  std::optional<RestWanted> rest_;
  std::optional<StockBefore> blank_;  ///< that the job states, as operations before leave it
  Plan plan_;
  Stages stages_;
  const ReportShare share_ = [this](double share) { return stages_.report(share); };
};

}  // namespace

Result<Plan> plan_indexed(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  const CutterType type = options.cutter.type;
  if (type != CutterType::kBall && type != CutterType::kTaperBall)
    return fail(Code::kInput, "the axis mode indexed needs a cutter of type ball or taper_ball");
  if (options.indexed.most_directions < 1 || options.indexed.most_directions > kMostDirections)
    return fail(Code::kInput, "axis.most_directions must be from 1 to " + std::to_string(kMostDirections));
  return Indexed(part, options, progress).run();
}

}  // namespace tiltfeed::pathgen
