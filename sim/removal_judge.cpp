#include <cmath>

#include "sim/removal_report.h"
#include "sim/text.h"

namespace tiltfeed::sim {
namespace {

/// What two neighbouring passes must leave between them on a plane, and four times that for curvature and
/// slopes, mm.
double scallop(const PlanOptions& plan) {
  if (plan.pattern.scallop > 0.0) return plan.pattern.scallop;
  const double radius = plan.cutter.radius(), half = 0.5 * plan.pattern.side_step;
  if (half >= radius) return radius;
  return 4.0 * (radius - std::sqrt(radius * radius - half * half));
}

}  // namespace

std::string trouble_text(const Trouble& t) {
  std::string line = text("%s %.4f mm deep, block %llu, line %u, at (%.3f, %.3f, %.3f)",
                          kToolPartNames[static_cast<int>(t.tool)], t.depth,
                          static_cast<unsigned long long>(t.block), t.line, t.place.x, t.place.y, t.place.z);
  if (t.facet != kNoFacet) line += text(", facet %u", t.facet);
  return line;
}

RemovalVerdict judge(const Removal& r, const RemovalContext& context) {
  const PlanOptions& plan = context.job.plan;
  RemovalVerdict verdict;
  verdict.tolerance = plan.tolerance;
  verdict.gouge = std::max(r.worst[static_cast<int>(TroubleKind::kGouge)], 0.0);
  verdict.excess_limit =
      plan.allowance + plan.radial_stock + plan.axial_stock + plan.tolerance + scallop(plan);
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
  return verdict;
}

}  // namespace tiltfeed::sim
