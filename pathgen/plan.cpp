#include "pathgen/plan.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "pathgen/cl_surface.h"
#include "pathgen/envelope.h"
#include "pathgen/far_side.h"
#include "pathgen/slices.h"

namespace tiltfeed {

namespace {

/// How the tolerance is shared out: the envelope's straight moves, then the points that are dropped. The rest
/// is the post's (its own share: JointPathOptions) and rounding's.
constexpr double kEnvelopeShare = 0.25;
constexpr double kThinningShare = 0.25;
/// Slices between two calls of the progress function.
constexpr std::size_t kSlicesPerReport = 64;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The stages' clock and the user's progress in one.
class Stages {
 public:
  Stages(const Progress& progress, std::vector<StageTime>& times) : progress_(progress), times_(times) {}
  /// Starts a stage, ending the one before; false if the user cancels.
  bool begin(const char* stage) {
    end();
    stage_ = stage;
    start_ = std::chrono::steady_clock::now();
    return report(0.0);
  }
  bool report(double fraction) const { return !progress_ || progress_(stage_, fraction); }
  void end() {
    if (stage_ != nullptr) times_.push_back({stage_, seconds_since(start_)});
    stage_ = nullptr;
  }

 private:
  const Progress& progress_;
  std::vector<StageTime>& times_;
  const char* stage_ = nullptr;
  std::chrono::steady_clock::time_point start_;
};

/// R of the maths: the mean distance of the CL surface from the axis feature, over the facets that face the
/// tool.
double mean_rho(const ClSurface& surface, const AxisFrame& frame) {
  if (frame.mode == AxisMode::kFixed) return 1.0;
  const Deformation probe(frame, 1.0);
  const Mesh& mesh = surface.mesh();
  double weight = 0.0, sum = 0.0;
  for (std::uint32_t f = 0; f < mesh.facets.size(); ++f) {
    const Point<Part> a = mesh.vertices[mesh.facets[f][0]], b = mesh.vertices[mesh.facets[f][1]],
                      c = mesh.vertices[mesh.facets[f][2]];
    const Point<Part> centre =
        lerp(lerp(a, b, 0.5), c, 1.0 / 3.0) + surface.facet_normal(f) * surface.radius();
    const double rho = std::abs(probe.flatten(centre).z);
    if (rho <= 0.0) continue;
    if (surface.sides() == Sides::kOutward && dot(surface.facet_normal(f), probe.axis_at(centre)) <= 0.0)
      continue;
    const double area = length(cross(b - a, c - a));
    weight += area, sum += area * rho;
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

/// (E5) The largest turn of the axis in one move: the ball's centre leaves its straight line by R turn^2 / 8
/// and the shank its ruled surface by (shank length) turn^2 / 8.
double largest_axis_step(const PlanOptions& options) {
  return std::sqrt(8.0 * options.tolerance * kThinningShare /
                   std::max(options.cutter.shank_length, options.cutter.radius()));
}

/// z' of the clearance surface.
Result<double> clearance_surface(const std::vector<std::vector<Pass>>& passes, const Deformation& deformation,
                                 const PlanOptions& options) {
  const double top = highest(passes), z = top + options.clearance;
  if (deformation.s() < 0.0 && z > -kLeastAxisDistance)
    return fail(Code::kLimit,
                "clearance_mm of " + std::to_string(options.clearance) +
                    " reaches the axis point, line or circle: the highest cutter location is only " +
                    std::to_string(-top) + " mm away from it; use a smaller clearance");
  return z;
}

void warn_too_near(const ClSurface& surface, const std::vector<std::vector<PatchId>>& too_near,
                   PlanReport& report) {
  std::vector<std::uint32_t> facets;
  for (const auto& patches : too_near)
    for (PatchId patch : patches) facets.push_back(surface.facet_of(patch));
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  if (facets.empty()) return;
  report.warnings.push_back(
      "near facet " + std::to_string(facets.front()) + " (" + std::to_string(facets.size()) +
      " facets in all) the CL surface touches the axis point, line or circle, where no tool axis is "
      "defined: what is nearer to it than 0.1 mm is not machined");
}

Result<void> check_options(const PlanOptions& o) {
  const auto positive = [](double v) { return std::isfinite(v) && v > 0.0; };
  if (!positive(o.cutter.diameter)) return fail(Code::kInput, "cutter.diameter_mm must be a positive length");
  if (!positive(o.side_step)) return fail(Code::kInput, "pattern.side_step_mm must be a positive length");
  if (!positive(o.tolerance)) return fail(Code::kInput, "tolerance_mm must be a positive length");
  if (!positive(o.clearance)) return fail(Code::kInput, "clearance_mm must be a positive length");
  if (!(o.allowance >= 0.0)) return fail(Code::kInput, "allowance_mm must be zero or more");
  if (!(o.approach >= 0.0)) return fail(Code::kInput, "approach_mm must be zero or more");
  return {};
}

void measure(const std::vector<Move>& moves, PlanReport& report) {
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const MoveKind kind = moves[i].kind;
    if (kind == MoveKind::kCut) ++report.points;
    if (kind == MoveKind::kPlunge) ++report.passes;
    if (i == 0) continue;
    (kind == MoveKind::kRapid ? report.rapid_length : report.cut_length) +=
        distance(moves[i - 1].pose.tip, moves[i].pose.tip);
  }
}

}  // namespace

Result<Plan> plan(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  const auto cancelled = fail(Code::kCancelled, "planning was cancelled; nothing was written");
  Plan result;
  PlanReport& report = result.report;
  Stages stages(progress, report.times);
  report.facets = part.mesh.facets.size();
  report.warnings = part.warnings;

  if (!stages.begin("CL surface")) return cancelled;
  const ClSurface surface(part.mesh, part.sides, options.cutter.radius() + options.allowance);
  const double scale = mean_rho(surface, options.axis);
  if (scale <= 0.0)
    return fail(Code::kUnreachable,
                "no facet of the part faces the tool: check axis.sense, axis.origin_mm and axis.n");
  const Deformation deformation(options.axis, scale);

  if (!stages.begin("slice")) return cancelled;
  const Result<Slices> slices = slice(surface, deformation, options.along, options.side_step);
  if (!slices) return tl::unexpected(slices.error());

  if (!stages.begin("envelope")) return cancelled;
  const EnvelopeOptions envelope{options.tolerance * kEnvelopeShare, largest_axis_step(options)};
  std::vector<std::vector<Pass>> passes(slices->count());
  std::vector<std::vector<PatchId>> too_near(slices->count());
  for (std::size_t from = 0; from < passes.size(); from += kSlicesPerReport) {
    const std::size_t to = std::min(from + kSlicesPerReport, passes.size());
    tbb::parallel_for(from, to, [&](std::size_t k) {
      SliceEnvelope found = upper_envelope(surface, deformation, *slices, k, envelope);
      passes[k] = std::move(found.passes);
      too_near[k] = std::move(found.too_near);
    });
    if (!stages.report(static_cast<double>(to) / static_cast<double>(passes.size()))) return cancelled;
  }
  for (const auto& of_slice : passes)
    for (const Pass& pass : of_slice) report.slice_points += pass.size();
  warn_too_near(surface, too_near, report);
  if (report.slice_points == 0)
    return fail(Code::kUnreachable,
                "the tool reaches no point of the part: check axis.sense, axis.origin_mm and axis.n");

  if (!stages.begin("clearance")) return cancelled;
  const Result<double> clearance_z = clearance_surface(passes, deformation, options);
  if (!clearance_z) return tl::unexpected(clearance_z.error());
  FarSide far_side(part.mesh, deformation, options.cutter, options.allowance, *clearance_z);
  const std::uint64_t trimmed = far_side.trim(passes);
  if (trimmed == report.slice_points)
    return fail(
        Code::kGouge,
        "at every point of the path the shank would hit the part beyond the point, line or circle; use a "
        "shorter cutter.shank_length_mm");
  if (trimmed > 0)
    report.warnings.push_back(
        std::to_string(trimmed) + " of " + std::to_string(report.slice_points) +
        " points left out: beyond the axis point, line or circle the shank would hit the part");

  if (!stages.begin("link")) return cancelled;
  tbb::parallel_for(std::size_t{0}, passes.size(), [&](std::size_t k) {
    for (Pass& pass : passes[k])
      pass = thinned(pass, options.tolerance * kThinningShare, envelope.max_axis_step);
  });
  const LinkOptions links{options.direction, options.cutter.radius(), *clearance_z, options.clearance,
                          options.approach};
  Linked linked = link(passes, surface, deformation, links, far_side);
  if (linked.skipped_passes > 0)
    report.warnings.push_back(
        std::to_string(linked.skipped_passes) +
        " passes left out: on the way to them the shank would hit the part beyond the axis point, "
        "line or circle; a shorter cutter.shank_length_mm may reach them");
  result.path.name = options.name;
  result.path.tool = {options.cutter.diameter, options.cutter.radius(), options.cutter.length};
  result.path.cut_feed = options.cut_feed;
  result.path.plunge_feed = options.plunge_feed;
  result.path.moves = std::move(linked.moves);
  measure(result.path.moves, report);
  stages.end();
  return result;
}

}  // namespace tiltfeed
