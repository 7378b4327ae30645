#include "pathgen/plan/predefined_axis.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

#include "kinematics/basics/tolerance_budget.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/envelope/pass_trim.h"
#include "pathgen/envelope/thinning.h"
#include "pathgen/linking/linking.h"
#include "pathgen/linking/opposite_wall.h"
#include "pathgen/options/axis_step.h"
#include "pathgen/options/option_checks.h"
#include "pathgen/pattern/holder_clearance.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/pattern/pattern.h"
#include "pathgen/plan/inside_solid.h"
#include "pathgen/plan/layer_stock.h"
#include "pathgen/plan/lean_stage.h"
#include "pathgen/plan/likely_cause.h"
#include "pathgen/plan/over_blank.h"
#include "pathgen/plan/rejected_points.h"
#include "pathgen/plan/rest_material.h"
#include "pathgen/progress/stages.h"
#include "pathgen/surface/cl_field.h"
#include "pathgen/tool/blank_solid.h"
#include "pathgen/tool/face_containment.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

namespace {

EnvelopeOptions envelope_options(const PlanOptions& options) {
  const ToleranceBudget budget(options.tolerance);
  EnvelopeOptions envelope{budget.envelope(), largest_axis_step(options)};
  if (options.max_point_distance > 0.0) envelope.max_distance = options.max_point_distance;
  envelope.reach = options.cutter.shank_length;
  envelope.turn_tolerance = budget.shank_turn();
  return envelope;
}

/// z' of the clearance surface. In outside work it clears every vertex of the part, machined or not; in
/// inside work, where room is short, the highest cutter location, or what the part's nearest vertex could
/// make of it where there is room for that. Fixtures count as the part does.
Result<double> clearance_surface(const Mesh& mesh, double top, const Deformation& deformation,
                                 const PlanOptions& options) {
  const double lift = reference_height(options.cutter) + options.allowance + options.axial_stock;
  double bound = top;
  for (Point<Part> v : mesh.vertices) bound = std::max(bound, deformation.height(v) + lift);
  if (options.fixtures) {
    const double above = reference_height(options.cutter) + options.fixture_room.cutter;
    for (Point<Part> v : options.fixtures->mesh.vertices)
      bound = std::max(bound, deformation.height(v) + above);
  }
  if (options.blank)
    for (Point<Part> v : options.blank->mesh().vertices)
      bound = std::max(bound, deformation.height(v) + reference_height(options.cutter));
  const double z = top + options.links.clearance;
  if (deformation.s() > 0.0) return bound + options.links.clearance;
  if (bound + options.links.clearance <= -kLeastAxisDistance) return bound + options.links.clearance;
  if (z > -kLeastAxisDistance)
    return fail(Code::kLimit,
                "clearance_mm of " + number_text(options.links.clearance) +
                    " reaches the axis point, line or circle: the highest cutter location is only " +
                    number_text(std::floor(-1000.0 * top) / 1000.0) +
                    " mm away from it; use a smaller clearance");
  return z;
}

/// The story, stage by stage; each leaves its result for the next. Errors as plan().
class Planner {
 public:
  /// `wanted` may be null: everywhere.
  Planner(const CheckedMesh& part, const PlanOptions& options, const WantedPart* wanted,
          const Progress& progress, Plan& result)
      : part_(part),
        options_(options),
        pass_options_(may_lean(options) ? without_leaning_parts(options) : options),
        wanted_(wanted),
        faces_(options.only_faces ? std::make_unique<const FaceContainment>(options) : nullptr),
        budget_(options.tolerance),
        envelope_(envelope_options(options)),
        path_(result.path),
        report_(result.report),
        stages_(progress, result.report.times) {}

  Result<void> run() {
    report_.facets = part_.mesh.facets.size();
    report_.warnings = part_.warnings;
    if (!stages_.begin("CL surface")) return cancelled();
    auto made = make_field(part_, pass_options_, report_.warnings, share_);
    if (!made) return tl::unexpected(made.error());
    std::shared_ptr<const ClField> field = std::move(*made);
    if (auto done = find_passes(field); !done) return done;
    const Result<double> clearance_z = clearance_surface(part_.mesh, top_, field->deformation, options_);
    if (!clearance_z) return tl::unexpected(clearance_z.error());
    if (auto done = join(*field, *clearance_z); !done) return done;
    measure(path_.moves, report_);
    if (options_.find_rest_material && wants_all()) {
      if (!stages_.begin("uncut")) return cancelled();
      OppositeWall opposite_wall(part_.mesh, field->deformation, options_, *clearance_z);
      report_.uncut = find_rest_material(
          *field, pass_options_, envelope_, path_.moves, share_,
          [&](const EnvelopePoint& stand) { return opposite_wall.keeps_off(stand); }, held_upright());
      if (stages_.stopped()) return cancelled();
      warn_between(report_.uncut->between,
                   options_.pattern.measure == StepMeasure::kScallop
                       ? "use a smaller pattern.scallop_mm, or cut steep walls with kind: z_level or split"
                       : "use a smaller pattern.side_step_mm, or pattern.measure: surface or scallop",
                   report_);
    }
    for (KeptByFixture& kept : report_.fixtures)
      for (std::size_t body = 0; report_.uncut && body < report_.uncut->fixture_area.size(); ++body)
        if (options_.fixtures->names[body] == kept.name) kept.area = report_.uncut->fixture_area[body];
    warn_fixtures("points of the passes", report_);
    stages_.end();
    return {};
  }

 private:
  /// The passes of the pattern, without what may not be cut, thinned. Where shank or holder matter, `field`
  /// becomes that with their patches.
  Result<void> find_passes(std::shared_ptr<const ClField>& field) {
    const bool starts_inside = field->starts_inside;
    // Smoothing lifts passes; only as they were, they tell which of shank and holder may touch.
    const bool guarded = tool_pieces(pass_options_).size() > 1;
    other_warnings_ = report_.warnings.size();
    auto passes = guarded ? trace_to_guard(*field) : trace("passes", *field, options_.smoothing);
    if (!passes) return tl::unexpected(passes.error());
    if (may_lean(options_)) cutter_field_ = field;
    if (guarded)
      if (auto done = heed_guards(field, passes); !done) return done;
    if (starts_inside)
      if (auto done = leave_material(part_.mesh, options_.axis.sense, *passes, report_); !done) return done;
    if (may_lean(options_)) found_ = *passes;
    passes_ = std::move(passes->rows);
    as_given_ = passes->as_given;
    floors_ = std::move(passes->floors);
    report_.slice_points = passes->traced;
    report_.ridge = passes->ridge;
    // The first level lies up to a step under the top of the surface.
    top_ = passes->top + (passes->as_given ? options_.pattern.step_down : 0.0);
    if (options_.blank && !floors_.empty()) top_ = std::max(top_, floors_.front());
    // In a hollow a step may reach past the axis feature, the surface does not.
    if (field->deformation.s() < 0.0 && !options_.blank)
      top_ = std::min(top_, std::max(passes->top, field->index.top()));
    warn_too_near(field->surface, passes->too_near, report_);
    warn_smoothed(passes->smoothed, report_);
    if (report_.slice_points == 0)
      return fail(Code::kUnreachable,
                  "the tool reaches no facet of the part: check axis.sense, axis.origin_mm, axis.n and "
                  "containment");
    PlanReport elsewhere = report_;
    if (auto done =
            report_refusals(field->surface, *passes, pass_options_, wants_all() ? report_ : elsewhere);
        !done)
      return done;
    return is_cut_down() ? keep_wanted(*field) : Result<void>{};
  }

  /// At most so far apart passes are asked, mm; more where all of them is wanted.
  double spacing() const {
    const double of_faces = faces_ ? faces_->spacing() : std::numeric_limits<double>::infinity();
    return has_places() ? std::min(of_faces, wanted_->spacing) : of_faces;
  }

  bool has_places() const { return wanted_ != nullptr && wanted_->place; }
  /// Is there nothing of the part that is not asked for?
  bool wants_all() const { return !has_places() || wanted_->whole; }

  /// Passes over all that a pass may come to lie on.
  Result<Passes> trace_to_guard(const ClField& field) {
    if (pass_options_.pattern.measure != StepMeasure::kRidge) return trace("passes", field, 0.0);
    PlanOptions evenly = pass_options_;
    evenly.pattern.measure = StepMeasure::kFlat, evenly.pattern.scallop = 0.0;
    return trace("passes", field, 0.0, evenly);
  }

  /// Passes that keep shank and holder off, and what is cut into where they only report.
  Result<void> heed_guards(std::shared_ptr<const ClField>& field, Result<Passes>& passes) {
    if (!stages_.begin("guards")) return cancelled();
    depth_.emplace(*passes, *field, pass_options_);
    auto guarded = holder_field(*field, pass_options_, *depth_, false, share_);
    if (stages_.stopped()) return cancelled();
    const bool again =
        guarded != nullptr || options_.smoothing > 0.0 || options_.pattern.measure == StepMeasure::kRidge;
    if (guarded) field = std::move(guarded);
    if (again) passes = trace("shank and holder", *field, options_.smoothing);
    if (!passes) return tl::unexpected(passes.error());
    if (!stages_.begin("touches")) return cancelled();
    if (auto reported = holder_field(*field, pass_options_, {*passes, *field, pass_options_}, true,
                                     part_of(share_, 0.0, 0.5)))
      warn_touches(find_touches(*reported, envelope_, *passes, part_of(share_, 0.5, 1.0)), report_);
    if (stages_.stopped()) return cancelled();
    return {};
  }

  /// Is what the pattern gives more than what is to be cut?
  bool is_cut_down() const { return has_places() || faces_; }

  /// Cuts the passes, which have been to what is wanted, and thins them once more.
  Result<void> keep_wanted(const ClField& field) {
    for (const std::vector<Pass>& row : passes_)
      for (const Pass& pass : row)
        for (std::size_t i = 1; i < pass.size(); ++i)
          report_.pattern_length += distance(pass[i - 1].centre, pass[i].centre);
    const auto near = [this](const EnvelopePoint& p) { return faces_->near(p.centre, p.axis); };
    tbb::parallel_for(std::size_t{0}, passes_.size(), [&](std::size_t i) {
      std::vector<Pass>& row = passes_[i];
      for (Pass& pass : row) pass = spaced(std::move(pass), field.deformation, spacing());
      if (faces_) row = keep_where(row, field.deformation, near, 0.0);
      if (has_places())
        row = wanted_->bridge > 0.0
                  ? bridged(row)
                  : broken(keep_where(row, field.deformation, wanted_->place, wanted_->overlap));
      for (Pass& pass : row) pass = thinned(pass, thinning(), envelope_);
    });
    if (std::any_of(passes_.begin(), passes_.end(), [](const auto& row) { return !row.empty(); })) return {};
    return fail(Code::kUnreachable,
                !wants_all() ? "nothing that is wanted of this direction is in its reach" : kNoFaceReached);
  }

  /// The passes from a point before what is wanted to one behind it. A short way over what is not is quicker
  /// than up and down.
  std::vector<Pass> bridged(const std::vector<Pass>& passes) const {
    std::vector<Pass> pieces;
    for (const Pass& pass : passes) {
      std::optional<std::size_t> begin;
      std::size_t last = 0;
      double off = 0.0;  // since the last place that is wanted
      const auto put = [&] {
        const std::size_t to = std::min(last + 2, pass.size());
        pieces.emplace_back(pass.begin() + static_cast<std::ptrdiff_t>(*begin),
                            pass.begin() + static_cast<std::ptrdiff_t>(to));
        begin.reset();
      };
      for (std::size_t i = 0; i < pass.size(); ++i) {
        if (i > 0) off += distance(pass[i - 1].centre, pass[i].centre);
        if (begin && off > wanted_->bridge) put();
        if (!wanted_->place(pass[i])) continue;
        if (!begin) begin = i > 0 ? i - 1 : 0;
        last = i, off = 0.0;
      }
      if (begin) put();
    }
    std::erase_if(pieces, [](const Pass& piece) { return piece.size() < 2; });
    return pieces;
  }

  /// The passes without the moves that may not be cut.
  std::vector<Pass> broken(const std::vector<Pass>& passes) const {
    if (!wanted_->straight) return passes;
    std::vector<Pass> pieces;
    for (const Pass& pass : passes) {
      Pass piece;
      for (const EnvelopePoint& p : pass) {
        if (!piece.empty() && !wanted_->straight(piece.back(), p)) {
          if (piece.size() > 1) pieces.push_back(piece);
          piece.clear();
        }
        piece.push_back(p);
      }
      if (piece.size() > 1) pieces.push_back(std::move(piece));
    }
    return pieces;
  }

  /// Two thinnings share what one may leave.
  double thinning() const { return budget_.thinning() * (is_cut_down() ? 0.5 : 1.0); }

  Result<Passes> trace(const char* stage, const ClField& field, double smoothing) {
    return trace(stage, field, smoothing, pass_options_);
  }
  Result<Passes> trace(const char* stage, const ClField& field, double smoothing, PlanOptions options) {
    if (!stages_.begin(stage)) return cancelled();
    EnvelopeOptions envelope = envelope_;
    envelope.max_distance = std::min(envelope.max_distance, spacing());
    options.smoothing = smoothing;
    report_.warnings.resize(other_warnings_);  // those of passes that these replace
    return trace_pattern(
        field, options, envelope, thinning(),
        [this](const char*, double share) { return stages_.report(share); }, report_.warnings);
  }

  /// ShankCollision on the opposite wall, links.
  Result<void> join(const ClField& field, double clearance_z) {
    if (!stages_.begin("clearance")) return cancelled();
    OppositeWall opposite_wall(part_.mesh, field.deformation, options_, clearance_z);
    std::uint64_t left = 0;
    for (const auto& passes : passes_)
      for (const Pass& pass : passes) left += pass.size();
    // What may lean is held against all of the part, wherever it is.
    std::optional<OppositeWall> of_the_rest;
    if (may_lean(options_)) of_the_rest.emplace(part_.mesh, field.deformation, pass_options_, clearance_z);
    const std::uint64_t trimmed = (of_the_rest ? *of_the_rest : opposite_wall).trim(passes_, share_);
    if (stages_.stopped()) return cancelled();
    const auto none = [](const std::vector<Pass>& row) { return row.empty(); };
    if (std::all_of(passes_.begin(), passes_.end(), none))
      return fail(
          Code::kGouge,
          "at every point of the path shank or holder would hit the part beyond the point, line or circle; "
          "use a shorter cutter.shank_length_mm");
    if (trimmed > 0)
      report_.warnings.push_back(
          std::to_string(trimmed) + " of " + std::to_string(left) +
          " points left out: beyond the axis point, line or circle shank or holder would hit the part");

    if (auto done = begin_off_blank(passes_, options_, field.deformation, clearance_z); !done) return done;
    if (auto done = lean(field, clearance_z); !done) return done;
    if (!stages_.begin("link")) return cancelled();
    const ClField& linked_field = lean_ ? lean_->linked() : field;
    const LayerStock stock(part_.bounds, options_, field.deformation, floors_, clearance_z);
    const Linking links{.direction = as_given_ ? Direction::kOneWay : options_.pattern.direction,
                        .reference_height = reference_height(options_.cutter),
                        .clearance_z = clearance_z,
                        .clearance = options_.links.clearance,
                        .approach = options_.links.approach,
                        .join_distance = options_.links.join_distance,
                        .lead_radius = options_.links.lead_radius,
                        .thinning = budget_.thinning(),
                        .plunge_ratio = options_.cut_feed.mm_per_min() / options_.plunge_feed.mm_per_min(),
                        .cut_speed = options_.cut_feed.mm_per_s(),
                        .rapid = options_.links.rapid,
                        .up = options_.up,
                        .tilt_max = options_.tilt_max,
                        .order = as_given_                                         ? PassOrder::kGiven
                                 : options_.pattern.measure == StepMeasure::kRidge ? PassOrder::kTimed
                                                                                   : PassOrder::kRegions,
                        .rounds = as_given_ ? 0 : options_.links.rounds,
                        .known =
                            [this](Point<Flat> place) {
                              return (!depth_ || depth_->knows(place)) && (!lean_ || lean_->knows(place));
                            },
                        .allowed =
                            [rules = PointRules(options_, linked_field)](const EnvelopePoint& p) {
                              return !rules.refusal(p) && rules.region().contains(p.flat) &&
                                     rules.near_faces_on_way(p);
                            },
                        .straight = wanted_ != nullptr ? wanted_->straight : nullptr,
                        .leaned = lean_ ? &lean_->ways() : nullptr,
                        .free_from = free_from(stock, field.deformation, clearance_z),
                        .in_blank = meets_blank(options_, field.deformation),
                        .report = share_};
    Envelope envelope(linked_field.surface, linked_field.deformation, linked_field.index, envelope_);
    Linked linked = link(passes_, linked_field, links, opposite_wall, envelope);
    if (stages_.stopped()) return cancelled();
    if (linked.moves.empty())
      return fail(
          Code::kInput,
          "there is no way to any pass: over the clearance surface, past the middle of the circle, the "
          "tool would be in the blank; state the blank as it is, with its hollow (blank.shape: file), "
          "or leave blank out");
    if (linked.tilted_passes > 0)
      report_.warnings.push_back(
          std::to_string(linked.tilted_passes) +
          " passes left out: every way to them over the clearance surface tilts the tool axis further than "
          "setup.tilt_max_deg; turn the part on the table");
    if (linked.skipped_passes > 0)
      report_.warnings.push_back(
          std::to_string(linked.skipped_passes) +
          " passes left out: every way to them hits the part, over the clearance surface or beyond the axis "
          "point, line or circle; a smaller clearance_mm or a shorter cutter.shank_length_mm may reach them");
    if (linked.straight_ends > 0)
      report_.warnings.push_back(std::to_string(linked.straight_ends) +
                                 " ends of passes have no room for an arc of links.lead_radius_mm: straight "
                                 "there");
    report_.retracts = linked.retracts, report_.joins = linked.joins;
    report_.closed_rows = linked.closed_rows;
    path_.moves = std::move(linked.moves);
    return {};
  }

  /// The passes with leans where guards ask for them.
  Result<void> lean(const ClField& field, double clearance_z) {
    if (!may_lean(options_)) return {};
    if (!stages_.begin("lean")) return cancelled();
    lean_.emplace(part_, options_, envelope_, field, clearance_z);
    const auto done = lean_->run(*cutter_field_, found_, passes_, report_, share_);
    if (!done) return done;
    if (std::none_of(passes_.begin(), passes_.end(), [](const auto& row) { return !row.empty(); }))
      return fail(Code::kUnreachable,
                  "nothing is left to cut: shank or holder come too near everywhere, and no lean of up to "
                  "axis.lean_limit_deg clears them; raise it, or use a longer or thinner tool");
    return {};
  }

  HeldUpright held_upright() const {
    if (!lean_) return {};
    return [this](const EnvelopePoint& stand) { return lean_->held(stand); };
  }

  /// What is known of the stock: what operations before leave, what the layers above leave.
  std::function<double(Point<Flat>, double)> free_from(const LayerStock& stock, const Deformation& field,
                                                       double clearance_z) const {
    const bool known = wanted_ != nullptr && wanted_->free_from;
    if (!known && floors_.empty()) return {};
    return [this, known, &stock, &field, clearance_z](Point<Flat> place, double to) {
      const double before = known ? wanted_->free_from(field, place, clearance_z, to) : clearance_z;
      return std::min(before, floors_.empty() ? clearance_z : stock.free_from(place, to));
    };
  }

  const CheckedMesh& part_;
  const PlanOptions& options_;
  const PlanOptions pass_options_;  ///< of the passes before they lean
  const WantedPart* wanted_;
  const std::unique_ptr<const FaceContainment> faces_;  ///< null: all of the part
  ToleranceBudget budget_;
  EnvelopeOptions envelope_;
  std::vector<std::vector<Pass>> passes_;                  ///< by line
  std::vector<double> floors_;                             ///< of roughing
  bool as_given_ = false;                                  ///< they keep their order and direction
  double top_ = -std::numeric_limits<double>::infinity();  ///< highest z' of the envelope
  std::shared_ptr<const ClField> cutter_field_;  ///< where passes may lean: that of the cutting part
  Passes found_;                                 ///< and the passes that it gave
  std::optional<PassDepth> depth_;               ///< under which the field knows neither shank nor holder
  std::optional<LeanStage> lean_;
  ToolPath& path_;
  PlanReport& report_;
  std::size_t other_warnings_ = 0;  ///< than of passes
  Stages stages_;
  const ReportShare share_ = [this](double share) { return stages_.report(share); };
};

}  // namespace

void measure(const std::vector<Move>& moves, PlanReport& report) {
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const MoveKind kind = moves[i].kind;
    if (kind == MoveKind::kCut) ++report.points;
    if (i == 0) continue;
    // Leads and ways close by the part plunge too; a pass begins where the tool comes to touch.
    if (kind == MoveKind::kPlunge && moves[i].facet != kNoFacet) ++report.passes;
    (kind == MoveKind::kRapid ? report.rapid_length : report.cut_length) +=
        distance(moves[i - 1].pose.tip, moves[i].pose.tip);
  }
}

Plan plan_without_moves(const PlanOptions& options) {
  Plan plan;
  plan.path.name = options.name;
  plan.path.tool = {options.cutter.diameter, options.cutter.nose_radius(), options.cutter.length};
  plan.path.cut_feed = options.cut_feed;
  plan.path.plunge_feed = options.plunge_feed;
  return plan;
}

Result<Plan> plan_where(const CheckedMesh& part, const PlanOptions& options, const WantedPart* wanted,
                        const Progress& progress) {
  if (auto ok = check_options(options); !ok) return tl::unexpected(ok.error());
  Plan plan = plan_without_moves(options);
  const auto done = Planner(part, options, wanted, progress, plan).run();
  if (!done) return tl::unexpected(with_cause(done.error(), part, options));
  return plan;
}

}  // namespace tiltfeed::pathgen
