#include "pathgen/pattern/point_rules.h"

namespace tiltfeed::pathgen {

std::optional<RestReason> PointRules::refusal(const EnvelopePoint& p) const {
  if (dot(p.axis, options_.up) < least_upright_) return RestReason::kTilt;
  if (!region_.reaches(p.flat.z)) return RestReason::kContainment;
  const ToolPiece& piece = touching(p);
  if (piece.at_fixtures) return RestReason::kFixture;
  const ToolPart part = piece.part;
  // On the axis of the mode itself what lets the tool lean may not stand there either.
  const auto left_out = [](Reaction r) { return r == Reaction::kTrim || r == Reaction::kTilt; };
  if (part == ToolPart::kShank && left_out(options_.shank.reaction)) return RestReason::kShank;
  if (part == ToolPart::kHolder && left_out(options_.holder.reaction)) return RestReason::kHolder;
  return std::nullopt;
}

bool PointRules::may_cut(const EnvelopePoint& p, RejectedPoints& refusals) const {
  const std::optional<RestReason> why = refusal(p);
  if (!near_faces(p)) return ++refusals.beside, !why;
  if (why == RestReason::kFixture) return refuse(p, refusals), false;
  if (why) ++refusals.count[static_cast<std::size_t>(*why)];
  const ToolPart part = touching(p).part;
  if (part == ToolPart::kCutter || touching(p).at_fixtures) return !why;
  refusals.patches.push_back(p.patch);
  if (!why) ++refusals.raised[static_cast<std::size_t>(rest_reason_of(part))];
  return !why;
}

void PointRules::refuse(const EnvelopePoint& held, RejectedPoints& refusals) const {
  const ToolPiece& piece = touching(held);
  if (!near_faces(held)) {
    ++refusals.beside;
    return;
  }
  if (!piece.at_fixtures) {
    ++refusals.count[static_cast<std::size_t>(rest_reason_of(piece.part))];
    refusals.patches.push_back(held.patch);
    return;
  }
  Deformation::Angles angles;
  const AxisLine line = field_.deformation.axis_line(held.flat.x, held.flat.y, angles);
  const auto may_touch = [&](PatchId patch) {
    ClHit hit;
    return surface_.top(patch, line, hit) && field_.deformation.in_column(hit.z, angles, 0.0);
  };
  const auto at_part = [](const ToolPiece& any) { return !any.at_fixtures; };
  if (!field_.index.any_touched(held.flat.x, held.flat.y, line, {}, surface_, at_part, may_touch)) {
    ++refusals.beside;
    return;
  }
  ++refusals.count[static_cast<std::size_t>(RestReason::kFixture)];
  RejectedPoints::OfFixture& body = refusals.fixtures[surface_.facet_of(held.patch)];
  if (body.points++ == 0) body.first = held.centre;
}

void RejectedPoints::add(const RejectedPoints& other) {
  for (std::size_t i = 0; i < count.size(); ++i) count[i] += other.count[i], raised[i] += other.raised[i];
  patches.insert(patches.end(), other.patches.begin(), other.patches.end());
  beside += other.beside;
  for (const auto& [body, more] : other.fixtures) {
    OfFixture& own = fixtures[body];
    if (own.points == 0) own.first = more.first;
    own.points += more.points;
  }
}

}  // namespace tiltfeed::pathgen
