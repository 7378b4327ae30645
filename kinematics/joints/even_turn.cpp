#include "kinematics/joints/even_turn.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed {
namespace {

constexpr int kSweeps = 60;
/// Over-relaxation.
constexpr double kBeyond = 1.7;
/// Nearer to the cone than this share of it, from inside, is on it.
constexpr double kInside = 1e-9;

/// Into the cone, on the even way to the planned axis.
AxisAngles into_cone(const AxisAngles& axis, const TurnNode& node) {
  AxisAngles in = axis;
  for (double lean = angle_between(in, node.axis); lean > node.cone; lean = angle_between(in, node.axis))
    in = on_way(node.axis, in, node.cone / lean * (1.0 - kInside));
  return in;
}

/// One after the other between its neighbours, `step` nodes apart, forwards and backwards in turn.
void sweep(const std::vector<TurnNode>& nodes, std::size_t step, std::vector<AxisAngles>& axes) {
  const std::size_t last = nodes.size() - 1;
  const auto settle = [&](std::size_t i) {
    if (nodes[i].cone <= 0.0) return;
    const std::size_t a = i - step, b = std::min(i + step, last);
    const double f = (nodes[i].seconds - nodes[a].seconds) / (nodes[b].seconds - nodes[a].seconds);
    axes[i] = into_cone(on_way(axes[i], on_way(axes[a], axes[b], f), kBeyond), nodes[i]);
  };
  for (int k = 0; k < kSweeps; ++k) {
    const std::size_t count = (last - 1) / step;  // at step, 2 step .. count step
    for (std::size_t j = 1; j <= count; ++j) settle((k % 2 == 0 ? j : count + 1 - j) * step);
  }
}

}  // namespace

double angle_between(const AxisAngles& a, const AxisAngles& b) {
  const auto haversine = [](double angle) {
    const double s = std::sin(angle / 2.0);
    return s * s;
  };
  const double h =
      haversine(a.tilt - b.tilt) + std::sin(a.tilt) * std::sin(b.tilt) * haversine(a.turn - b.turn);
  return 2.0 * std::asin(std::sqrt(std::clamp(h, 0.0, 1.0)));
}

AxisAngles on_way(const AxisAngles& a, const AxisAngles& b, double f) {
  return {a.tilt + (b.tilt - a.tilt) * f, a.turn + (b.turn - a.turn) * f};
}

std::vector<AxisAngles> even_turn(const std::vector<TurnNode>& nodes, const std::vector<AxisAngles>& near) {
  std::vector<AxisAngles> axes = near;
  if (axes.empty())
    for (const TurnNode& node : nodes) axes.push_back(node.axis);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    axes[i] = nodes[i].cone <= 0.0 ? nodes[i].axis : into_cone(axes[i], nodes[i]);
  if (nodes.size() < 3) return axes;
  std::size_t coarsest = 1;
  while (near.empty() && coarsest * 16 < nodes.size()) coarsest *= 2;
  for (std::size_t step = coarsest;; step /= 2) {
    sweep(nodes, step, axes);
    const std::size_t half = step / 2;
    if (half == 0) return axes;
    // The nodes of the next finer step begin between these.
    for (std::size_t i = half; i + half < nodes.size(); i += step) {
      const std::size_t a = i - half, b = i + half;
      const double f = (nodes[i].seconds - nodes[a].seconds) / (nodes[b].seconds - nodes[a].seconds);
      if (nodes[i].cone > 0.0) axes[i] = into_cone(on_way(axes[a], axes[b], f), nodes[i]);
    }
  }
}

double turn_cost(const std::vector<TurnNode>& nodes, const std::vector<AxisAngles>& axes) {
  double sum = 0.0;
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    const double tilt = axes[i].tilt - axes[i - 1].tilt, turn = axes[i].turn - axes[i - 1].turn;
    sum += (tilt * tilt + turn * turn) / (nodes[i].seconds - nodes[i - 1].seconds);
  }
  return sum;
}

}  // namespace tiltfeed
