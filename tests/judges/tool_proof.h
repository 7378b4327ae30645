#pragma once
// Holds any tool path against the part with the true solids of cutter, shank and holder: clearances along
// cuts and links, contact of the rounded end along cuts. Knows nothing of how the path was planned.

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/solid/tool_solid.h"
#include "tests/judges/path_proof.h"

namespace tiltfeed {
using namespace pathgen;

/// The worst of some poses.
struct Worst {
  double value = 0.0;
  Pose at;
  std::size_t move = 0;
  void see(double v, const Pose& pose, std::size_t i) {
    if (v > value) value = v, at = pose, move = i;
  }
};

struct ToolFindings {
  std::size_t cut_poses = 0, link_poses = 0;  ///< looked at
  std::array<Worst, 3> cut, link;  ///< how much cutter, shank, holder fall short of their clearance, mm
  Worst contact;                   ///< gap between the rounded end and the part on cuts, mm
  std::size_t buried = 0;          ///< poses wholly inside the material
  double gouge() const {
    double most = 0.0;
    for (int i = 0; i < 3; ++i) most = std::max({most, cut[i].value, link[i].value});
    return most;
  }
};

class ToolProof {
 public:
  /// `part` must outlive the proof. `clearance`: what cutter, shank and holder must keep, mm; `growth`: the
  /// stock that shall stay.
  ToolProof(const sim::PartDistance& part, const Box& bounds, const Cutter& cutter, double tolerance,
            std::array<double, 3> clearance = {}, const sim::Growth& growth = {})
      : part_(part),
        bounds_(bounds),
        tool_(cutter, growth),
        apart_(cutter, growth, 0.0),
        nose_(cutter.nose_radius()),
        tolerance_(tolerance),
        clearance_(clearance) {}

  /// On cuts the cutter is looked at every `spacing` mm of its end's way, shank and holder where between two
  /// looks kFarSpacing or less of motion could bring them nearer than the worst found. Links are followed so
  /// closely that nothing comes nearer than the worst found by more than half the tolerance.
  ToolFindings measure(const ToolPath& path, double spacing) const {
    ToolFindings found;
    State state;
    const std::size_t stride = 1 + path.moves.size() / kBuriedLooks;
    for (std::size_t i = 1; i < path.moves.size(); ++i) {
      follow(path.moves[i - 1].pose, path.moves[i], i, spacing, state, found);
      if (i % stride == 0 && is_buried(path.moves[i].pose)) ++found.buried;
    }
    return found;
  }

 private:
  static constexpr std::size_t kBuriedLooks = 200;
  static constexpr double kFarSpacing = 0.25;  ///< mm

  struct State {
    std::array<double, 3> free{};  ///< how far the part may move before it is looked at again, mm
    std::array<std::uint32_t, 3> hint{kNoFacet, kNoFacet, kNoFacet};
    std::uint32_t gap_hint = kNoFacet;
  };

  void follow(const Pose& from, const Move& move, std::size_t index, double spacing, State& state,
              ToolFindings& found) const {
    const bool is_cut = move.kind == MoveKind::kCut;
    const double turn = angle_between(from.axis, move.pose.axis), way = distance(from.tip, move.pose.tip);
    const double motion = way + std::hypot(tool_.top(), tool_.widest()) * turn;
    const int looks = is_cut ? std::max(2, static_cast<int>((way + 2.0 * nose_ * turn) / spacing) + 1) : 0;
    const double stride = is_cut ? kFarSpacing : 0.5 * tolerance_;
    const int steps = std::max(1, static_cast<int>(motion / stride) + 1);
    for (int k = 1; k <= looks; ++k)
      look_at_end(between(from, move.pose, static_cast<double>(k) / looks), index, state, found);
    for (int k = 1; k <= steps; ++k)
      for (int part = is_cut ? 1 : 0; part < 3; ++part) {
        state.free[part] -= motion / steps;
        if (state.free[part] > 0.0 || !tool_.has(sim::kToolParts[part])) continue;
        const Pose pose = between(from, move.pose, static_cast<double>(k) / steps);
        const sim::Hit hit =
            (clearance_[part] > 0.0 ? apart_ : tool_)
                .clearance(part_, pose, sim::kToolParts[part], sim::kInfinity, state.hint[part]);
        state.hint[part] = hit.facet;
        const double spare = hit.value - clearance_[part];
        Worst& worst = (is_cut ? found.cut : found.link)[part];
        worst.see(-spare, pose, index);
        state.free[part] = spare + worst.value + 0.5 * tolerance_;
        ++(is_cut ? found.cut_poses : found.link_poses);
      }
    if (is_cut) state.free[0] = 0.0;
  }

  /// The whole cutting part for gouges, its rounded end for contact.
  void look_at_end(const Pose& pose, std::size_t index, State& state, ToolFindings& found) const {
    ++found.cut_poses;
    const sim::Hit near =
        tool_.clearance(part_, pose, sim::ToolPart::kCutter, -found.cut[0].value, state.hint[0]);
    if (near.facet != kNoFacet) state.hint[0] = near.facet, found.cut[0].see(-near.value, pose, index);
    const sim::Hit gap = tool_.gap(part_, pose, sim::kInfinity, state.gap_hint);
    state.gap_hint = gap.facet;
    found.contact.see(gap.value, pose, index);
  }

  /// No facet cuts such a tool, so that its clearances show nothing. Its upper end tells.
  bool is_buried(const Pose& pose) const {
    const Point<Part> top = pose.tip + pose.axis * tool_.top();
    const bool in_box = top.x > bounds_.min.x && top.y > bounds_.min.y && top.z > bounds_.min.z &&
                        top.x < bounds_.max.x && top.y < bounds_.max.y && top.z < bounds_.max.z;
    return in_box && part_.winding_number(pose.tip + pose.axis * nose_) > 0.5;
  }

  const sim::PartDistance& part_;
  Box bounds_;
  sim::ToolSolid tool_, apart_;  ///< apart: its parts do not reach into each other
  double nose_, tolerance_;
  std::array<double, 3> clearance_;
};

}  // namespace tiltfeed
