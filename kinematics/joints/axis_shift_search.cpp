#include "kinematics/joints/axis_shift_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// An axis nearer to the pole than this (rad) has the rotary of a place this much further on its way.
constexpr double kOnPole = 1e-6;
// Rounding of bends against the slope, as a share of the largest bend.
constexpr double kSlopeRounding = 1e-9;

}  // namespace

Vec3 bent_axis(const ShiftNode& node, double bend) {
  return normalized(node.pose.axis * std::cos(bend) + cross(node.pose.axis, node.ahead) * std::sin(bend));
}

std::vector<Vec3> AxisShiftSearch::shifts_of(const ShiftNode& node) const {
  const Vec3 left = cross(node.pose.axis, node.ahead);
  std::vector<Vec3> shifts{{}};
  const auto add = [&](Vec3 axis) {
    const double side = std::asin(std::clamp(dot(axis, left), -1.0, 1.0));
    if (side >= node.low && side <= node.high) shifts.push_back(axis - node.pose.axis);
  };
  // The smallest first: of equally good shifts that is taken.
  for (int level = 1; level < kBendLevels; ++level)
    for (const int side : {1, -1}) add(bent_axis(node, side * most_ * level / kBendLevels));
  for (const double most : {node.high, node.low})
    if (std::abs(most) == most_) shifts.push_back(bent_axis(node, most) - node.pose.axis);
  const double through = std::asin(std::clamp(dot(pole_, left), -1.0, 1.0));
  if (std::abs(through) <= most_) add(bent_axis(node, through));
  if (angle_between(pole_, node.pose.axis) <= most_) add(pole_);
  return shifts;
}

void AxisShiftSearch::add_states(const ShiftNode& node, Vec3 shift, std::vector<State>& states) const {
  Vec3 axis = node.pose.axis + shift;
  if (length(cross(axis, pole_)) < kOnPole) axis = axis + node.ahead * (2.0 * kOnPole);
  const RotarySolutions solutions = chooser_.solve({node.pose.tip, normalized(axis)});
  if (!solutions.reachable) return;
  for (const RotarySolutions::Words& words : solutions.words)
    for (const double turn : {0.0, -360.0, 360.0})
      if (words.tilt + turn >= machine_.tilt.min && words.tilt + turn <= machine_.tilt.max) {
        states.push_back({shift, words.tilt + turn, words.rotary});
        break;
      }
}

double AxisShiftSearch::step(const State& from, const State& to, double minutes) const {
  const double turn_a = (to.a - from.a) / machine_.tilt.velocity,
               turn_c = std::remainder(to.c - from.c, 360.0) / machine_.rotary.velocity,
               lean = kBendWorth * length(to.shift) / most_;
  return (turn_a * turn_a + turn_c * turn_c) / minutes + minutes * lean * lean;
}

std::optional<double> AxisShiftSearch::run(const std::vector<ShiftNode>& nodes,
                                           const std::vector<std::vector<State>>& states,
                                           std::vector<Vec3>* shifts) const {
  std::vector<double> cost(states[0].size(), 0.0);
  std::vector<std::vector<std::size_t>> parents(nodes.size());
  for (std::size_t j = 1; j < nodes.size(); ++j) {
    const double minutes = nodes[j].minutes - nodes[j - 1].minutes,
                 slope = kBendSlope * (nodes[j].turned - nodes[j - 1].turned) + kSlopeRounding * most_;
    std::vector<double> next(states[j].size(), kNever);
    parents[j].assign(states[j].size(), 0);
    for (std::size_t k = 0; k < states[j].size(); ++k)
      for (std::size_t i = 0; i < states[j - 1].size(); ++i) {
        const State &from = states[j - 1][i], &to = states[j][k];
        if (!(cost[i] < next[k]) || squared_length(to.shift - from.shift) > slope * slope) continue;
        const double sum = cost[i] + step(from, to, minutes);
        if (sum < next[k]) next[k] = sum, parents[j][k] = i;
      }
    cost = std::move(next);
  }
  const auto least = std::min_element(cost.begin(), cost.end());
  if (least == cost.end() || !(*least < kNever)) return std::nullopt;
  if (shifts != nullptr) {
    shifts->assign(nodes.size(), {});
    auto at = static_cast<std::size_t>(least - cost.begin());
    for (std::size_t j = nodes.size(); j-- > 0;) {
      (*shifts)[j] = states[j][at].shift;
      if (j > 0) at = parents[j][at];
    }
  }
  return *least;
}

std::optional<std::vector<Vec3>> AxisShiftSearch::best(const std::vector<ShiftNode>& nodes) const {
  std::vector<std::vector<State>> states(nodes.size());
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    const bool end = j == 0 || j + 1 == nodes.size();
    for (const Vec3 shift : end ? std::vector<Vec3>{{}} : shifts_of(nodes[j]))
      add_states(nodes[j], shift, states[j]);
  }
  std::vector<Vec3> shifts;
  if (!run(nodes, states, &shifts)) return std::nullopt;
  return shifts;
}

std::optional<double> AxisShiftSearch::cost(const std::vector<ShiftNode>& nodes,
                                            const std::vector<Vec3>& shifts) const {
  std::vector<std::vector<State>> states(nodes.size());
  for (std::size_t j = 0; j < nodes.size(); ++j) add_states(nodes[j], shifts[j], states[j]);
  return run(nodes, states, nullptr);
}

}  // namespace tiltfeed
