#include "sim/solid/tool_solid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace tiltfeed::sim {
namespace {

/// A piece while joints are made: the rounded end, if any, and the rims above it.
struct Draft {
  ToolPart part = ToolPart::kCutter;
  std::vector<Corner> nose;
  std::vector<std::array<double, 2>> rims;      ///< (r, h)
  double lower = 0.0, upper = 0.0;              ///< heights
  double lower_slope = 0.0, upper_slope = 0.0;  ///< dr/dh at both ends

  Revolved solid() const {
    if (nose.empty()) return Revolved::from_rims(rims);
    std::vector<Corner> corners = nose;
    const auto above = Revolved::from_rims(rims).corners();
    corners.insert(corners.end(), above.begin(), above.end());
    return Revolved(corners);
  }
};

/// The cutting part: a face of radius e with its edge rounded by c, then straight up or along the cone.
Draft cutting_part(const pathgen::Cutter& cutter) {
  const double radius = cutter.diameter / 2.0;
  double e = 0.0, c = radius, taper = 0.0;
  if (cutter.type == pathgen::CutterType::kBullNose) c = cutter.corner_radius, e = radius - c;
  if (cutter.type == pathgen::CutterType::kFlat) c = 0.0, e = radius;
  if (cutter.type == pathgen::CutterType::kTaperBall) taper = cutter.taper.radians();
  const double whole = cutter.cutting_length > 0.0 ? cutter.cutting_length : cutter.shank_length;
  const double rounded = c * (1.0 - std::sin(taper)), top = std::max(whole, rounded);
  Draft draft;
  draft.nose = {{e, c, c, kPi / 2.0 - taper}};
  draft.upper_slope = std::tan(taper);
  draft.rims = {{e + c * std::cos(taper) + (top - rounded) * draft.upper_slope, top}};
  draft.upper = top;
  return draft;
}

Draft frustum(ToolPart part, double lower_radius, double upper_radius, double lower, double upper) {
  const double slope = (upper_radius - lower_radius) / (upper - lower);
  return {part, {}, {{lower_radius, lower}, {upper_radius, upper}}, lower, upper, slope, slope};
}

/// Cutting part, shank and holder, from the tip up.
std::vector<Draft> drafts(const pathgen::Cutter& cutter) {
  std::vector<Draft> all{cutting_part(cutter)};
  double at = all[0].upper;
  if (cutter.shank_length > at) {
    const double radius = cutter.shank_diameter > 0.0 ? cutter.shank_diameter / 2.0 : all[0].rims[0][0];
    all.push_back(frustum(ToolPart::kShank, radius, radius, at, cutter.shank_length));
    at = cutter.shank_length;
  }
  for (const pathgen::HolderStep& step : cutter.holder) {
    all.push_back(frustum(ToolPart::kHolder, step.lower_diameter / 2.0, step.upper_diameter / 2.0, at,
                          at + step.length));
    at += step.length;
  }
  return all;
}

/// Lets neighbours reach into each other where one fits into the other.
void join(std::vector<Draft>& all, double overlap) {
  std::vector<Revolved> plain;
  for (const Draft& draft : all) plain.push_back(draft.solid());
  for (std::size_t i = 1; i < all.size(); ++i) {
    Draft &below = all[i - 1], &above = all[i];
    const double joint = below.upper, lower_radius = below.rims.back()[0], upper_radius = above.rims[0][0];
    if (upper_radius <= lower_radius) {
      const double by = std::min(overlap, 0.5 * (joint - below.lower));
      const double most = plain[i - 1].radius_at(joint - by);
      above.rims.insert(above.rims.begin(),
                        {std::clamp(upper_radius - by * above.lower_slope, 0.0, most), joint - by});
    }
    if (lower_radius <= upper_radius) {
      const double by = std::min(overlap, 0.5 * (above.upper - joint));
      const double most = plain[i].radius_at(joint + by);
      below.rims.push_back({std::clamp(lower_radius + by * below.upper_slope, 0.0, most), joint + by});
    }
  }
}

}  // namespace

Hit clearance(const PartDistance& surface, const Revolved& solid, const Pose& pose, double bound,
              std::uint32_t hint) {
  const Standing standing(solid, pose);
  Hit hit{bound, kNoFacet};
  surface.search(
      hit.value, hint, [&](Vec3 low, Vec3 high) { return standing.distance_bound(low, high); },
      [&](const Triangle& t) {
        const double d = standing.distance(t, hit.value);
        if (d < hit.value) hit = {d, t.facet};
      });
  return hit;
}

Hit drop(const PartDistance& surface, const Revolved& solid, const Pose& pose, double bound,
         std::uint32_t hint, double enough) {
  const Standing standing(solid, pose);
  Hit hit{bound, kNoFacet};
  surface.search(
      bound, hint, [&](Vec3 low, Vec3 high) { return standing.drop_bound(low, high); },
      [&](const Triangle& t) {
        const double d = standing.drop(t, bound);
        if (d < bound) hit = {d, t.facet}, bound = d > enough ? d : -kInfinity;
      });
  return hit;
}

ToolSolid::ToolSolid(const pathgen::Cutter& cutter, const Growth& growth, double overlap) {
  assert(cutter.diameter > 0.0);
  std::vector<Draft> all = drafts(cutter);
  const auto grown = [&](const Revolved& solid) {
    return solid.grown(growth.allowance, growth.radial, growth.axial);
  };
  cutting_.push_back(grown(all[0].solid()));
  const Corner nose = all[0].nose[0];
  if (cutter.type == pathgen::CutterType::kBall) {
    end_.push_back(grown(Revolved({{nose.r, nose.h, nose.radius, kPi}})));
  } else if (cutter.type == pathgen::CutterType::kTaperBall) {
    end_.push_back(cutting_[0]);
  } else {
    end_.push_back(grown(Revolved({nose, {nose.r + nose.radius, nose.h, 0.0, kPi}})));
  }
  const bool is_capsule = cutter.type == pathgen::CutterType::kBall && all.size() == 1 &&
                          all[0].upper >= 2.0 * nose.radius && growth.radial == 0.0 && growth.axial == 0.0;
  if (is_capsule) {
    const double upper = all[0].upper;
    capsule_ = Capsule{nose.radius, upper - nose.radius, upper, nose.radius + growth.allowance};
  }
  if (overlap > 0.0) join(all, overlap);
  for (const Draft& draft : all) pieces_[static_cast<int>(draft.part)].push_back(grown(draft.solid()));
}

Hit ToolSolid::clearance(const PartDistance& surface, const Pose& pose, ToolPart part, double bound,
                         std::uint32_t hint) const {
  Hit hit{bound, kNoFacet};
  if (capsule_ && part == ToolPart::kCutter) {
    if (bound + capsule_->radius <= 0.0) return hit;
    const Point<Part> centre = pose.tip + pose.axis * capsule_->centre;
    const Hit near =
        surface.nearest({centre, pose.tip + pose.axis * capsule_->upper}, bound + capsule_->radius, hint);
    if (near.facet == kNoFacet) return hit;
    // The tool is between both capsules: where they agree, it agrees with them.
    const Segment within{centre, pose.tip + pose.axis * capsule_->within};
    const Hit inner = surface.nearest(within, near.value + kSearchError, near.facet);
    if (inner.facet != kNoFacet) return {near.value - capsule_->radius, near.facet};
    hint = near.facet;
  }
  for (const Revolved& piece : pieces(part)) {
    const Hit near = sim::clearance(surface, piece, pose, hit.value, hint);
    if (near.facet != kNoFacet) hit = near;
  }
  return hit;
}

Hit ToolSolid::gap(const PartDistance& surface, const Pose& pose, double bound, std::uint32_t hint) const {
  if (!capsule_) return sim::clearance(surface, end_[0], pose, bound, hint);
  const Hit near = surface.nearest(pose.tip + pose.axis * capsule_->centre, bound + capsule_->radius, hint);
  return near.facet == kNoFacet ? Hit{bound, kNoFacet} : Hit{near.value - capsule_->radius, near.facet};
}

Hit ToolSolid::drop(const PartDistance& surface, const Pose& pose, double bound, std::uint32_t hint,
                    double enough) const {
  if (!capsule_) return sim::drop(surface, cutting_[0], pose, bound, hint, enough);
  return surface.first_touch(pose.tip + pose.axis * capsule_->centre, -pose.axis, capsule_->radius, bound,
                             hint);
}

double ToolSolid::widest() const {
  double most = 0.0;
  for (const auto& part : pieces_)
    for (const Revolved& piece : part) most = std::max(most, piece.widest());
  return most;
}

double ToolSolid::narrowest() const {
  double least = kInfinity;
  for (const auto& part : pieces_)
    for (const Revolved& piece : part) least = std::min(least, piece.widest());
  return least;
}

double ToolSolid::top() const {
  double most = 0.0;
  for (const auto& part : pieces_)
    for (const Revolved& piece : part) most = std::max(most, piece.corners().back().h);
  return most;
}

}  // namespace tiltfeed::sim
