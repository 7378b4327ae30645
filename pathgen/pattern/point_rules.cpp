#include "pathgen/pattern/point_rules.h"

namespace tiltfeed::pathgen {

std::optional<RestReason> PointRules::refusal(const EnvelopePoint& p) const {
  if (dot(p.axis, options_.up) < least_upright_) return RestReason::kTilt;
  if (!region_.reaches(p.flat.z)) return RestReason::kContainment;
  const ToolPart part = touching(p);
  if (part == ToolPart::kShank && options_.shank.reaction == Reaction::kTrim) return RestReason::kShank;
  if (part == ToolPart::kHolder && options_.holder.reaction == Reaction::kTrim) return RestReason::kHolder;
  return std::nullopt;
}

bool PointRules::may_cut(const EnvelopePoint& p, RejectedPoints& refusals) const {
  const std::optional<RestReason> why = refusal(p);
  if (why) ++refusals.count[static_cast<std::size_t>(*why)];
  const ToolPart part = touching(p);
  if (part == ToolPart::kCutter) return !why;
  refusals.patches.push_back(p.patch);
  if (!why) ++refusals.raised[static_cast<std::size_t>(rest_reason_of(part))];
  return !why;
}

void RejectedPoints::add(const RejectedPoints& other) {
  for (std::size_t i = 0; i < count.size(); ++i) count[i] += other.count[i], raised[i] += other.raised[i];
  patches.insert(patches.end(), other.patches.begin(), other.patches.end());
}

}  // namespace tiltfeed::pathgen
