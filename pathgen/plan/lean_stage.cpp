#include "pathgen/plan/lean_stage.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pathgen/pattern/holder_clearance.h"
#include "pathgen/plan/rejected_points.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

namespace {

std::string mm_text(double mm) { return number_text(std::round(100.0 * mm) / 100.0); }
std::string degrees_text(double rad) {
  return number_text(std::round(100.0 * Angle::from_radians(rad).degrees()) / 100.0);
}

}  // namespace

LeanStage::LeanStage(const CheckedMesh& part, const PlanOptions& options, const EnvelopeOptions& envelope,
                     const ClField& field, double clearance_z)
    : part_(part),
      options_(options),
      field_(field),
      tool_(part.mesh, options, field.deformation, clearance_z),
      envelope_(field.surface, field.deformation, field.index, envelope) {
  ways_ = {&field_, &envelope_, [this](const EnvelopePoint& end) { return leaned_end(tool_, end); },
           [this](const EnvelopePoint& end) { return tool_.rapid_end(end, end.axis); },
           [this](const EnvelopePoint& a, const Pass& between, const EnvelopePoint& b) {
             return leaned_join(tool_, a, between, b);
           }};
}

Result<void> LeanStage::run(const ClField& cutter, const Passes& found,
                            std::vector<std::vector<Pass>>& passes, PlanReport& report,
                            const ReportShare& share) {
  std::vector<std::string> told_before;
  if (options_.fixtures) {
    auto made = make_field(part_, options_, told_before, part_of(share, 0.0, 0.1));
    if (!made) return tl::unexpected(made.error());
    fixtures_ = std::move(*made);
  }
  const ClField& field = fixtures_ ? *fixtures_ : cutter;
  depth_.emplace(found, field, options_);
  guarded_ = holder_field(field, options_, *depth_, false, part_of(share, 0.1, 0.2));
  if (share && !share(0.2)) return cancelled();
  if (!guarded_ && fixtures_) guarded_ = std::move(fixtures_);
  if (!guarded_) return {};  // nothing comes near shank or holder
  const LeanFigures figures = lean_passes(tool_, passes, part_of(share, 0.2, 1.0));
  if (share && !share(1.0)) return cancelled();
  return tell(figures, report);
}

Result<void> LeanStage::tell(const LeanFigures& figures, PlanReport& report) const {
  report.lean = LeanReport{figures.leaned, figures.left, Angle::from_radians(figures.largest)};
  for (const auto& [body, by] : figures.fixtures) {
    const std::string& name = options_.fixtures->names[body];
    const auto known = std::find_if(report.fixtures.begin(), report.fixtures.end(),
                                    [&](const KeptByFixture& kept) { return kept.name == name; });
    if (known == report.fixtures.end())
      report.fixtures.push_back({name, by.places, by.first});
    else
      known->points += by.places;
  }
  const std::string most = degrees_text(options_.lean.limit.radians());
  const auto tell_left = [&](const HeldBy& by, const char* what, RestReason why) {
    if (by.places == 0) return;
    report.warnings.push_back(
        mm_text(by.length) + " mm of the passes left out: the " + what +
        " would come nearer to the part than guards." + what + ".clearance_mm, and no lean of up to " + most +
        " degrees clears it, stopped by facet " + std::to_string(part_.mesh.source[by.facets.front()]) +
        " (" + std::to_string(by.facets.size()) + " facets in all); raise axis.lean_limit_deg, or " +
        remedy(why));
  };
  tell_left(figures.shank, "shank", RestReason::kShank);
  tell_left(figures.holder, "holder", RestReason::kHolder);
  return {};
}

std::optional<HeldStand> LeanStage::held(const EnvelopePoint& stand) const {
  std::uint32_t hint = kNoFacet;
  const auto found = tool_.held(stand, hint);
  if (!found) return std::nullopt;
  if (found->of_fixtures)
    return HeldStand{RestReason::kFixture, options_.fixtures->mesh.source[found->facet]};
  return HeldStand{rest_reason_of(found->part), 0};
}

}  // namespace tiltfeed::pathgen
