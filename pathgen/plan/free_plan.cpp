#include "pathgen/plan/free_plan.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/envelope/pass_trim.h"
#include "pathgen/free_axis/free_links.h"
#include "pathgen/free_axis/tool_axis_path.h"
#include "pathgen/free_slices/cl_slices.h"
#include "pathgen/options/axis_step.h"
#include "pathgen/plan/rejected_points.h"
#include "pathgen/plan/rest_of_cells.h"
#include "pathgen/plan/stock_before.h"
#include "pathgen/progress/stages.h"
#include "pathgen/progress/watch.h"
#include "pathgen/tool/face_containment.h"
#include "pathgen/tool/tool_in_blank.h"

namespace tiltfeed::pathgen {

namespace {

/// Passes between two reports of how far it is; the threads wait for each other after so many.
constexpr std::size_t kPassesPerTurn = 128;

std::string percent(double part, double whole) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f %%", 100.0 * part / whole);
  return text;
}

constexpr Reason kNoDirection[] = {
    {RestReason::kCutter, "no direction of the tool axis is clear of the part for the cutter"},
    {RestReason::kShank,
     "in every direction that is clear for the cutter the shank comes nearer to the part than "
     "guards.shank.clearance_mm"},
    {RestReason::kHolder,
     "in every direction that is clear for cutter and shank the holder comes nearer to the part "
     "than guards.holder.clearance_mm"},
    {RestReason::kFixture,
     "in every direction that is clear of the part the tool comes nearer to a fixture than its clearance"},
    {RestReason::kTilt, "every clear direction tilts the tool axis further than setup.tilt_max_deg"}};

/// The pieces of a chain along which the ball is near to a chosen face, each end within kTrimStep of where it
/// ceases to be.
std::vector<ClChain> near_faces(ClChain chain, const FaceContainment& faces) {
  const auto near = [&](const ClPoint& p) { return faces.near_ball(p.centre); };
  ClStrand& points = chain.points;
  if (chain.closed) {
    const auto away = std::find_if_not(points.begin(), points.end(), near);
    if (away == points.end()) return {std::move(chain)};
    const auto at = away - points.begin();
    points.pop_back();
    std::rotate(points.begin(), points.begin() + at % std::ssize(points), points.end());
    points.push_back(points.front());
  }
  std::vector<ClChain> pieces;
  bool on = near(points.front());
  if (on) pieces.push_back({{points.front()}, false});
  for (std::size_t i = 1; i < points.size(); ++i) {
    // Steps no longer than a face's border is seen in.
    const double way = distance(points[i - 1].centre, points[i].centre);
    const double steps = std::max(1.0, std::ceil(way / faces.spacing()));
    for (double k = 1.0; k <= steps; ++k) {
      double same = (k - 1.0) / steps, other = k / steps;
      const ClPoint next = k == steps ? points[i] : between(points[i - 1], points[i], other);
      if (near(next) != on) {
        while ((other - same) * way > kTrimStep) {
          const double f = (same + other) / 2.0;
          (near(between(points[i - 1], points[i], f)) == on ? same : other) = f;
        }
        const ClPoint end = between(points[i - 1], points[i], on ? same : other);
        if (!on) pieces.emplace_back();
        pieces.back().points.push_back(end);
        on = !on;
      }
      if (on && k == steps) pieces.back().points.push_back(next);
    }
  }
  std::erase_if(pieces, [](const ClChain& piece) { return length_of(piece.points) < kTrimStep; });
  return pieces;
}

std::vector<ClSlice> near_faces(const std::vector<ClSlice>& slices, const FaceContainment& faces) {
  std::vector<std::vector<ClChain>> pieces(slices.size());
  tbb::parallel_for(std::size_t{0}, slices.size(),
                    [&](std::size_t i) { pieces[i] = near_faces(slices[i].chain, faces); });
  std::vector<ClSlice> kept;
  for (std::size_t i = 0; i < slices.size(); ++i)
    for (ClChain& piece : pieces[i])
      kept.push_back({slices[i].stack, slices[i].height, slices[i].plane, std::move(piece)});
  return kept;
}

/// Rapids of the first operation keep off all of the blank.
LinkStock all_of_it(const ToolInBlank& blank) {
  return {.clear_down_to = [&blank](Point<Part> reference, Vec3 axis, double high,
                                    double low) { return blank.clear_down_to(reference, axis, high, low); },
          .short_way_in =
              [&blank](const Pose& down, const Pose& up, const Pose& over) {
                return blank.moves_in(down, up) || blank.moves_in(up, over);
              }};
}

/// Those of another keep off what is left. Above a tool that has cut it is clear along the axis.
LinkStock what_is_left(const StockBefore& stock) {
  return {.clear_down_to = [&stock](Point<Part> reference, Vec3 axis, double high,
                                    double low) { return stock.clear_down_to(reference, axis, high, low); },
          .short_way_in = [&stock](const Pose&, const Pose& up,
                                   const Pose& over) { return stock.moves_in(up, over); }};
}

class FreePlanner {
 public:
  FreePlanner(const CheckedMesh& part, const PlanOptions& options, const Progress& progress, Plan& plan)
      : part_(part),
        options_(options),
        plan_(plan),
        report_(plan.report),
        free_(plan.report.free.emplace()),
        stages_(progress, plan.report.times) {}

  Result<void> run() {
    if (options_.free.plane_normals.empty())
      return fail(Code::kInput, "axis.plane_normals must have at least one direction");
    if (options_.cutter.type != CutterType::kBall && options_.cutter.type != CutterType::kTaperBall)
      return fail(Code::kInput,
                  "the axis mode free needs a ball or taper_ball cutter: others have no one CL surface for "
                  "all tool axes");
    report_.facets = part_.mesh.facets.size();
    report_.warnings = part_.warnings;
    const FacetBvh tree(part_.mesh);
    if (!stages_.begin("CL surface")) return cancelled();
    std::vector<ClSlice> slices = slice_cl_surface(part_, tree, options_, ToleranceBudget(options_.tolerance),
                                                   [&](double f) { return stages_.report(f); });
    if (stages_.stopped()) return cancelled();
    if (options_.only_faces && !slices.empty()) {
      slices = near_faces(slices, FaceContainment(options_));
      if (slices.empty()) return fail(Code::kUnreachable, kNoFaceReached);
    }
    for (const ClSlice& s : slices)
      free_.cl_length += length_of(s.chain.points), report_.slice_points += s.chain.points.size();
    if (slices.empty())
      return fail(Code::kUnreachable, "no plane of axis.plane_normals cuts the part within the containment");
    const SweptTool tool(tree, options_, ToleranceBudget(options_.tolerance).flank());
    const DirectionGrid grid(Admissibility::kAdmissibleLevel + 1);
    const Admissibility admissible(tool, grid, options_.up, options_.tilt_max);
    if (!stages_.begin("orientation")) return cancelled();
    const auto runs = orient(slices, admissible);
    if (stages_.stopped()) return cancelled();
    if (auto told = tell_left_out(tool); !told) return told;
    if (runs.empty())
      return fail(Code::kUnreachable, "nothing is left to cut: no pass is longer than a point");
    if (!stages_.begin("link")) return cancelled();
    join(runs, admissible);
    if (stages_.stopped()) return cancelled();
    if (options_.find_rest_material) {
      if (!stages_.begin("uncut")) return cancelled();
      report_.between = find_rest_of_cells(
          part_, options_, tool, DirectionGrid(Admissibility::kAdmissibleLevel).directions(),
          plan_.path.moves, [this](double share) { return stages_.report(share); });
      if (stages_.stopped()) return cancelled();
      warn_between(*report_.between, "use a smaller pattern.side_step_mm, or one more of axis.plane_normals",
                   report_);
    }
    stages_.end();
    return {};
  }

 private:
  ToolAxisOptions orientation() const {
    return {options_.free, options_.tolerance, largest_axis_step(options_), options_.max_point_distance,
            reference_height(options_.cutter)};
  }

  std::vector<ToolAxisRun> orient(const std::vector<ClSlice>& slices, const Admissibility& admissible) {
    const ToolAxisOptions how = orientation();
    const bool turned = options_.pattern.direction == Direction::kZigzag && !reversible();
    std::vector<ToolAxisPass> passes(slices.size());
    const ReportShare report = [this](double share) { return stages_.report(share); };
    Watch watch(report, slices.size());
    for (std::size_t first = 0; first < slices.size() && !watch.stopped(); first += kPassesPerTurn) {
      const auto one = [&](std::size_t i) {
        if (!watch.next()) return;
        if (!turned || slices[i].plane % 2 == 0) {
          passes[i] = choose_tool_axes(slices[i].chain, admissible, how);
          return;
        }
        ClChain back = slices[i].chain;
        std::reverse(back.points.begin(), back.points.end());
        passes[i] = choose_tool_axes(back, admissible, how);
      };
      // One by one: some take a hundred times as long as others.
      tbb::parallel_for(first, std::min(slices.size(), first + kPassesPerTurn), one,
                        tbb::simple_partitioner());
    }
    std::vector<ToolAxisRun> runs;
    for (ToolAxisPass& pass : passes) {
      free_.cl_points += pass.stations, free_.directions += pass.tested, free_.breaks += pass.breaks;
      left_out_.insert(left_out_.end(), pass.left_out.begin(), pass.left_out.end());
      for (ToolAxisRun& r : pass.runs) runs.push_back(std::move(r));
    }
    return runs;
  }

  /// Without lead and lean a pass is the same both ways.
  bool reversible() const {
    return options_.pattern.direction == Direction::kZigzag && options_.free.lead.radians() == 0.0 &&
           options_.free.lean.radians() == 0.0;
  }

  /// What has no admissible direction, by reason.
  Result<void> tell_left_out(const SweptTool& tool) {
    for (const LeftOut& l : left_out_) {
      if (l.why != RestReason::kFixture) continue;
      const auto& [a, b, c] = part_.mesh.facets[l.facet];
      const Point<Part> p = part_.mesh.vertices[a];
      const Vec3 ab = part_.mesh.vertices[b] - p, ac = part_.mesh.vertices[c] - p;
      ++note_fixture(options_, tool, p + (ab + ac) / 3.0, normalized(cross(ab, ac)), report_).points;
    }
    warn_fixtures("places of the slices", report_);
    double all = 0.0;
    for (const Reason& reason : kNoDirection) {
      double sum = 0.0;
      std::vector<std::uint32_t> facets;
      for (const LeftOut& l : left_out_) {
        if (l.why != reason.why) continue;
        sum += l.length, facets.push_back(part_.mesh.source[l.facet]);
      }
      if (facets.empty()) continue;
      std::sort(facets.begin(), facets.end());
      facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
      for (const std::uint32_t f : facets) free_.unreached.push_back({f, reason.why});
      all += sum;
      report_.warnings.push_back(percent(sum, free_.cl_length) +
                                 " of the CL surface's slices left out, at facet " +
                                 std::to_string(facets.front()) + " (" + std::to_string(facets.size()) +
                                 " facets in all): " + reason.text + "; " + remedy(reason.why));
    }
    free_.unreached_length = all;
    std::stable_sort(free_.unreached.begin(), free_.unreached.end(),
                     [](const auto& a, const auto& b) { return a.facet < b.facet; });
    if (left_out_.empty() || left_out_.size() < free_.cl_points) return {};
    const Reason& first = *std::find_if(std::begin(kNoDirection), std::end(kNoDirection),
                                        [this](const Reason& r) { return r.why == left_out_.front().why; });
    return fail(first.why == RestReason::kTilt ? Code::kLimit : Code::kUnreachable,
                std::string("nothing is left to cut: at facet ") +
                    std::to_string(part_.mesh.source[left_out_.front().facet]) + " as everywhere " +
                    first.text + "; " + remedy(first.why));
  }

  void join(const std::vector<ToolAxisRun>& runs, const Admissibility& admissible) {
    const ToolAxisOptions how = orientation();
    const std::optional<ToolInBlank> whole =
        options_.from_blank ? std::optional<ToolInBlank>(options_) : std::nullopt;
    std::optional<StockBefore> before;
    if (options_.blank && !options_.from_blank) before.emplace(part_, options_);
    const LinkStock stock = whole ? all_of_it(*whole) : before ? what_is_left(*before) : LinkStock{};
    FreeLinked linked = link_runs(runs, reversible(), admissible, how, options_, part_.mesh.source, stock,
                                  [this](double share) { return stages_.report(share); });
    free_.directions += linked.tested;
    report_.retracts = linked.retracts, report_.joins = linked.joins;
    free_.short_links = linked.short_links;
    if (linked.skipped_runs > 0)
      report_.warnings.push_back(std::to_string(linked.skipped_runs) +
                                 " runs left out: every way to them tilts the tool axis further than "
                                 "setup.tilt_max_deg; turn the part on the table");
    plan_.path.moves = std::move(linked.moves);
  }

  const CheckedMesh& part_;
  const PlanOptions& options_;
  Plan& plan_;
  PlanReport& report_;
  FreeReport& free_;
  std::vector<LeftOut> left_out_;
  Stages stages_;
};

}  // namespace

Result<void> plan_free(const CheckedMesh& part, const PlanOptions& options, const Progress& progress,
                       Plan& plan) {
  return FreePlanner(part, options, progress, plan).run();
}

}  // namespace tiltfeed::pathgen
