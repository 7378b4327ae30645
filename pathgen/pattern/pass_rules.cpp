#include "pathgen/pattern/pass_rules.h"

namespace tiltfeed {

std::optional<Uncut> PassRules::refusal(const EnvelopePoint& p) const {
  if (dot(p.axis, options_.up) < least_upright_) return Uncut::kTilt;
  if (!region_.reaches(p.flat.z)) return Uncut::kContainment;
  const ToolPart part = touching(p);
  if (part == ToolPart::kShank && options_.shank.reaction == Reaction::kTrim) return Uncut::kShank;
  if (part == ToolPart::kHolder && options_.holder.reaction == Reaction::kTrim) return Uncut::kHolder;
  return std::nullopt;
}

bool PassRules::may_cut(const EnvelopePoint& p, Refusals& refusals) const {
  const std::optional<Uncut> why = refusal(p);
  if (why) ++refusals.count[static_cast<std::size_t>(*why)];
  const ToolPart part = touching(p);
  if (part == ToolPart::kCutter) return !why;
  refusals.patches.push_back(p.patch);
  if (!why) ++refusals.raised[static_cast<std::size_t>(uncut_by(part))];
  return !why;
}

void Refusals::add(const Refusals& other) {
  for (std::size_t i = 0; i < count.size(); ++i) count[i] += other.count[i], raised[i] += other.raised[i];
  patches.insert(patches.end(), other.patches.begin(), other.patches.end());
}

}  // namespace tiltfeed
