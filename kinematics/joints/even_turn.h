#pragma once
// The evenest way of a tool axis through a row of cones, in the coordinates in which tilt and table move.
// (K18).

#include <vector>

namespace tiltfeed {

/// Where a tool axis points: its angle from the table's axis (0 to pi) and how far it is turned round that,
/// counted on over whole turns; rad.
struct AxisAngles {
  double tilt = 0.0, turn = 0.0;
  bool operator==(const AxisAngles&) const = default;
};

/// At a moment the axis is within a cone about a planned one.
struct TurnNode {
  AxisAngles axis;
  double seconds = 0.0;  ///< rises from node to node
  double cone = 0.0;     ///< rad, below pi / 2; 0: the axis is kept
};

/// The angle between two axes, rad.
double angle_between(const AxisAngles& a, const AxisAngles& b);
/// At the share `f` of the even way from a to b.
AxisAngles on_way(const AxisAngles& a, const AxisAngles& b, double f);

/// Axes, one a node, each in its cone, that make the sum of (tilt^2 + turn^2) / seconds over the ways between
/// neighbours the least, but for what sweeps from coarse to fine leave. `near`: axes to begin from; empty:
/// the planned ones.
std::vector<AxisAngles> even_turn(const std::vector<TurnNode>& nodes, const std::vector<AxisAngles>& near);
/// That sum, rad^2 / s.
double turn_cost(const std::vector<TurnNode>& nodes, const std::vector<AxisAngles>& axes);

}  // namespace tiltfeed
