#include <cmath>

#include "sim/basics/text.h"
#include "sim/report/report.h"

namespace tiltfeed::sim {

bool asks_all(const pathgen::PlanOptions& plan) {
  return plan.pattern.kind != pathgen::PatternKind::kPencil && plan.rest_more_than == 0.0;
}

namespace {

/// What two neighbouring passes must leave between them on a plane, and for curvature and slopes twice that
/// where the side step is measured on the part, four times where it is flat, mm.
double scallop(const pathgen::PlanOptions& plan) {
  const pathgen::Pattern& pattern = plan.pattern;
  if (pattern.measure == pathgen::StepMeasure::kScallop) return pattern.scallop;
  if (!asks_all(plan)) return plan.cutter.radius();
  // Layers of roughing leave terraces.
  if (pattern.kind == pathgen::PatternKind::kRough) return pattern.step_down;
  const bool levels =
      pattern.kind == pathgen::PatternKind::kZLevel || pattern.kind == pathgen::PatternKind::kSplit;
  const double radius = plan.cutter.radius(),
               half = 0.5 * std::max(pattern.side_step, levels ? pattern.step_down : 0.0);
  if (half >= radius) return radius;
  const double times = pattern.measure == pathgen::StepMeasure::kSurface ? 2.0 : 4.0;
  return times * (radius - std::sqrt(radius * radius - half * half));
}

}  // namespace

double rest_limit(const pathgen::PlanOptions& plan) {
  return plan.allowance + plan.radial_stock + plan.axial_stock + plan.tolerance + scallop(plan);
}

std::string trouble_text(const Trouble& t) {
  std::string line = text("%s %.4f mm deep, block %llu, line %u, at (%.3f, %.3f, %.3f)",
                          kToolPartNames[static_cast<int>(t.tool)], t.depth,
                          static_cast<unsigned long long>(t.block), t.line, t.place.x, t.place.y, t.place.z);
  if (t.facet != kNoFacet) line += text(", facet %u", t.facet);
  return line;
}

namespace {

/// Lines of the stock that lie further apart than its skin is thick pass a tool that only runs in that skin
/// by.
std::string unseen_at(double cell, const RemovalContext& context) {
  const double skin = context.stock.margin;
  if (!(skin > 0.0) || cell <= skin) return "";
  return text(
      "lines of the stock are %.4g mm apart, and the stock is %.4g mm thicker than the part: a rapid or a "
      "shank that runs in it between two lines is not seen; --resolution %.4g sees it",
      cell, skin, 0.5 * skin);
}

/// Where the distance of the passes is it: of how much, and what helps.
std::string cause_of(const Rest& rest, const pathgen::PlanOptions& plan) {
  if (rest.between_passes == 0.0) return "";
  const pathgen::PatternKind kind = plan.pattern.kind;
  const std::string remedy =
      kind == pathgen::PatternKind::kZLevel  ? "levels leave more the flatter the part is: use a smaller "
                                               "pattern.step_down_mm, or kind: split"
      : kind == pathgen::PatternKind::kSplit ? "use a smaller pattern.side_step_mm or step_down_mm"
      : plan.pattern.measure == pathgen::StepMeasure::kFlat
          ? text(
                "use a smaller pattern.side_step_mm (%.4g now, measured flat), or pattern.measure: surface "
                "or "
                "scallop",
                plan.pattern.side_step)
          : "use a smaller pattern.side_step_mm or scallop_mm";
  return text("; on %.1f mm2 of that passes lie too far apart on the part, up to %.4g mm: %s",
              rest.between_passes, rest.apart, remedy.c_str());
}

}  // namespace

RemovalVerdict judge(const Removal& r, const RemovalContext& context) {
  const pathgen::PlanOptions& plan = context.job.plan;
  RemovalVerdict verdict;
  verdict.tolerance = plan.tolerance;
  verdict.gouge = std::max(r.worst[static_cast<int>(TroubleKind::kGouge)], 0.0);
  verdict.excess_limit = rest_limit(plan);
  verdict.unseen = unseen_at(r.cell, context);
  std::array<int, 4> count{};
  for (const Trouble& t : r.troubles) ++count[static_cast<int>(t.kind)];
  std::array<bool, 4> told{};
  for (const Trouble& t : r.troubles) {
    const int kind = static_cast<int>(t.kind);
    if (told[kind]) continue;
    told[kind] = true;
    std::string line = std::string(kTroubleNames[kind]) + ": " + trouble_text(t);
    if (count[kind] > 1) line += text("; %d places in all", count[kind]);
    verdict.failures.push_back(line);
  }
  if (r.haste.moves > 0) {
    const double feed = std::max(plan.cut_feed.mm_per_min(), plan.plunge_feed.mm_per_min());
    std::string line = text(
        "feed: %.0f mm/min at the tip, the job has %.0f: is a block missing before? block %llu, line %u, "
        "at (%.3f, %.3f, %.3f)",
        r.haste.feed, feed, static_cast<unsigned long long>(r.haste_block), r.haste_line, r.haste.place.x,
        r.haste.place.y, r.haste.place.z);
    if (r.haste.moves > 1)
      line += text("; %llu places in all", static_cast<unsigned long long>(r.haste.moves));
    verdict.failures.push_back(line);
  }
  if (r.touched == 0)
    verdict.failures.push_back(text("the cutter comes nowhere within %.3g mm of the part", r.reach));
  else if (r.excess[3] > verdict.excess_limit)
    verdict.failures.push_back(
        text("on half of the surface that was cut %.4f mm or more is left, limit %.4f mm", r.excess[3],
             verdict.excess_limit));
  // The first of the program's blocks only states the start.
  if (context.header.blocks && *context.header.blocks != r.blocks + 1)
    verdict.failures.push_back(text("the program has %llu blocks that move an axis, its header states %llu",
                                    static_cast<unsigned long long>(r.blocks + 1),
                                    static_cast<unsigned long long>(*context.header.blocks)));
  const Rest& rest = r.rest;
  if (rest.area > kLeastRest * (r.touched_area + rest.area))
    verdict.rest = text(
        "%.1f mm2 of the part that the tool reaches are left with more than %.4f mm; worst: %s, facet %u, at "
        "(%.3f, %.3f, %.3f)",
        rest.area, rest.limit, rest.never_cut ? "never cut" : text("%.4f mm left", rest.left).c_str(),
        rest.facet, rest.place.x, rest.place.y, rest.place.z);
  if (!verdict.rest.empty()) verdict.rest += cause_of(rest, plan);
  return verdict;
}

}  // namespace tiltfeed::sim
