#include "pathgen/plan.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "pathgen/cl_surface.h"
#include "pathgen/envelope.h"
#include "pathgen/exposure.h"
#include "pathgen/far_side.h"
#include "pathgen/linking.h"
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

/// z' of the clearance surface. In outside work it clears every vertex of the part, machined or not; in
/// inside work, where room is short, the highest cutter location.
Result<double> clearance_surface(const Mesh& mesh, const std::vector<std::vector<Pass>>& passes,
                                 const Deformation& deformation, const PlanOptions& options) {
  double top = highest(passes);
  if (deformation.s() > 0.0)
    for (Point<Part> v : mesh.vertices)
      top = std::max(top, deformation.flatten(v).z + options.cutter.radius() + options.allowance);
  const double z = top + options.links.clearance;
  if (deformation.s() < 0.0 && z > -kLeastAxisDistance)
    return fail(Code::kLimit,
                "clearance_mm of " + std::to_string(options.links.clearance) +
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
  if (!positive(o.pattern.side_step))
    return fail(Code::kInput, "pattern.side_step_mm must be a positive length");
  if (!positive(o.tolerance)) return fail(Code::kInput, "tolerance_mm must be a positive length");
  if (!positive(o.links.clearance)) return fail(Code::kInput, "clearance_mm must be a positive length");
  if (!(o.allowance >= 0.0)) return fail(Code::kInput, "allowance_mm must be zero or more");
  if (!(o.links.approach >= 0.0)) return fail(Code::kInput, "approach_mm must be zero or more");
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

/// Which sides of the facets to believe in: as checked, unless a facet turns its back to the tool openly.
Sides believed_sides(const CheckedMesh& part, const AxisFrame& axis, PlanReport& report) {
  if (part.sides == Sides::kBoth) return Sides::kBoth;
  const std::vector<std::uint32_t> backs = exposed_backs(part.mesh, Deformation(axis, 1.0));
  if (backs.empty()) return Sides::kOutward;
  const Point<Part> place = part.mesh.vertices[part.mesh.facets[backs.front()][0]];
  report.warnings.push_back(
      std::to_string(backs.size()) + " facets show the tool their inside, first facet " +
      std::to_string(part.mesh.source[backs.front()]) + " at " + to_string(place) +
      ": shells cross or fold there; both sides of every facet count as surface, and the tool "
      "keeps off both");
  return Sides::kBoth;
}

/// The story, stage by stage; each leaves its result for the next. Errors as plan().
class Planner {
 public:
  Planner(const CheckedMesh& part, const PlanOptions& options, const Progress& progress, Plan& result)
      : part_(part),
        options_(options),
        envelope_{options.tolerance * kEnvelopeShare, largest_axis_step(options)},
        path_(result.path),
        report_(result.report),
        stages_(progress, result.report.times) {}

  Result<void> run() {
    report_.facets = part_.mesh.facets.size();
    report_.warnings = part_.warnings;
    if (!stages_.begin("CL surface")) return cancelled();
    const Sides sides = believed_sides(part_, options_.axis, report_);
    const ClSurface surface(part_.mesh, sides, options_.cutter.radius() + options_.allowance);
    const double scale = mean_rho(surface, options_.axis);
    if (scale <= 0.0) return fail(Code::kUnreachable, kNothingFaces);
    const Deformation deformation(options_.axis, scale);

    if (!stages_.begin("slice")) return cancelled();
    const Result<Slices> slices =
        slice(surface, deformation, options_.pattern.along, options_.pattern.side_step);
    if (!slices) return tl::unexpected(slices.error());
    if (auto done = find_envelope(surface, deformation, *slices); !done) return done;
    // Before anything is left out: rapids must clear that, too.
    const Result<double> clearance_z = clearance_surface(part_.mesh, passes_, deformation, options_);
    if (!clearance_z) return tl::unexpected(clearance_z.error());
    if (auto done = keep_tilt(); !done) return done;
    if (auto done = join(surface, deformation, *clearance_z); !done) return done;
    measure(path_.moves, report_);
    stages_.end();
    return {};
  }

 private:
  static constexpr const char* kNothingFaces =
      "the tool reaches no facet of the part: check axis.sense, axis.origin_mm and axis.n";

  static tl::unexpected<Error> cancelled() {
    return fail(Code::kCancelled, "planning was cancelled; nothing was written");
  }

  Result<void> find_envelope(const ClSurface& surface, const Deformation& deformation, const Slices& slices) {
    if (!stages_.begin("envelope")) return cancelled();
    passes_.resize(slices.count());
    std::vector<std::vector<PatchId>> too_near(slices.count());
    for (std::size_t from = 0; from < passes_.size(); from += kSlicesPerReport) {
      const std::size_t to = std::min(from + kSlicesPerReport, passes_.size());
      tbb::parallel_for(from, to, [&](std::size_t k) {
        SliceEnvelope found = upper_envelope(surface, deformation, slices, k, envelope_);
        passes_[k] = std::move(found.passes);
        too_near[k] = std::move(found.too_near);
      });
      if (!stages_.report(static_cast<double>(to) / static_cast<double>(passes_.size()))) return cancelled();
    }
    for (const auto& of_slice : passes_)
      for (const Pass& pass : of_slice) report_.slice_points += pass.size();
    warn_too_near(surface, too_near, report_);
    if (report_.slice_points == 0) return fail(Code::kUnreachable, kNothingFaces);
    return {};
  }

  /// Leaves out what the head cannot tilt to.
  Result<void> keep_tilt() {
    const double tilt_max = options_.tilt_max.radians();
    if (tilt_max >= kPi) return {};
    const std::uint64_t steep = leave_out(
        passes_, [&](const EnvelopePoint& p) { return angle_between(p.axis, options_.up) > tilt_max; });
    if (steep == 0) return {};
    const std::string share =
        std::to_string(steep) + " of " + std::to_string(report_.slice_points) + " points";
    if (steep == report_.slice_points)
      return fail(Code::kLimit,
                  "at every point of the path the tool axis tilts further than setup.tilt_max_deg, " +
                      std::to_string(options_.tilt_max.degrees()) + " degrees; turn the part on the table");
    report_.warnings.push_back(share + " left out: the tool axis would tilt further than setup.tilt_max_deg");
    report_.slice_points -= steep;
    return {};
  }

  /// Clearance on the far side, thinning, links.
  Result<void> join(const ClSurface& surface, const Deformation& deformation, double clearance_z) {
    if (!stages_.begin("clearance")) return cancelled();
    FarSide far_side(part_.mesh, deformation, options_.cutter, options_.allowance, clearance_z);
    const std::uint64_t trimmed = far_side.trim(passes_);
    if (trimmed == report_.slice_points)
      return fail(Code::kGouge,
                  "at every point of the path the shank would hit the part beyond the point, line or circle; "
                  "use a shorter cutter.shank_length_mm");
    if (trimmed > 0)
      report_.warnings.push_back(
          std::to_string(trimmed) + " of " + std::to_string(report_.slice_points) +
          " points left out: beyond the axis point, line or circle the shank would hit the part");

    if (!stages_.begin("link")) return cancelled();
    tbb::parallel_for(std::size_t{0}, passes_.size(), [&](std::size_t k) {
      for (Pass& pass : passes_[k])
        pass = thinned(pass, options_.tolerance * kThinningShare, envelope_.max_axis_step);
    });
    const Linking links{options_.pattern.direction, options_.cutter.radius(), clearance_z,
                        options_.links.clearance, options_.links.approach};
    Linked linked = link(passes_, surface, deformation, links, far_side);
    if (linked.skipped_passes > 0)
      report_.warnings.push_back(
          std::to_string(linked.skipped_passes) +
          " passes left out: on the way to them the shank would hit the part beyond the axis "
          "point, line or circle; a shorter cutter.shank_length_mm may reach them");
    path_.moves = std::move(linked.moves);
    return {};
  }

  const CheckedMesh& part_;
  const PlanOptions& options_;
  EnvelopeOptions envelope_;
  std::vector<std::vector<Pass>> passes_;  ///< by slice
  ToolPath& path_;
  PlanReport& report_;
  Stages stages_;
};

}  // namespace

Result<Plan> plan(const CheckedMesh& part, const PlanOptions& options, const Progress& progress) {
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  Plan result;
  result.path.name = options.name;
  result.path.tool = {options.cutter.diameter, options.cutter.radius(), options.cutter.length};
  result.path.cut_feed = options.cut_feed;
  result.path.plunge_feed = options.plunge_feed;
  if (auto done = Planner(part, options, progress, result).run(); !done) return tl::unexpected(done.error());
  return result;
}

}  // namespace tiltfeed
