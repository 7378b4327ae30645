#pragma once
// A joint path against its tool path, by dense sampling with forward(): shared by the joint path tests.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "kinematics/basics/decimal.h"
#include "kinematics/joints/joint_path.h"

namespace tiltfeed::joint_check {

constexpr double kTurn = 360.0;

inline MachineModel trunnion(Vec3 head = {1, 0, 0}) {
  MachineModel m;
  m.name = "test";
  m.x = m.y = m.z = {-1000, 1000, 12000, 2000};
  m.tilt = {'A', head, +1, 0.0, -120, 120, 5400, 1000};
  m.rotary = {'C', {0, 0, 1}, -1, 0.0, -36000, 36000, 7200, 1000};
  m.pivot_to_gauge = {0, 0, -150};
  return m;
}

inline tiltfeed::Setup standing() {
  tiltfeed::Setup setup;
  setup.part_zero = {20, -10, 60};
  setup.tool_length = 100;
  return setup;
}

inline Vec3 axis_at(double tilt_deg, double azimuth_deg) {
  const double t = Angle::from_degrees(tilt_deg).radians(), z = Angle::from_degrees(azimuth_deg).radians();
  return normalized(Vec3{std::sin(t) * std::cos(z), std::sin(t) * std::sin(z), std::cos(t)});
}

inline ToolPath path_of(const std::vector<Pose>& poses, MoveKind kind = MoveKind::kCut) {
  ToolPath path;
  path.name = "test";
  path.tool = {6.0, 3.0, 100.0};
  path.cut_feed = Feed::from_mm_per_min(1200);
  path.plunge_feed = Feed::from_mm_per_min(300);
  for (const Pose& pose : poses)
    path.moves.push_back({pose, path.moves.empty() ? MoveKind::kRapid : kind, kNoFacet});
  return path;
}

/// Angle from u to the great-circle arc a..b, degrees.
inline double off_arc(Vec3 u, Vec3 a, Vec3 b) {
  const Vec3 n = cross(a, b);
  double off = std::min(angle_between(u, a), angle_between(u, b));
  if (length(n) > 1e-12) {
    const Vec3 unit = normalized(n), foot = u - unit * dot(u, unit);
    if (length(foot) > 1e-9 && dot(cross(a, foot), unit) >= 0 && dot(cross(foot, b), unit) >= 0)
      off = std::min(off, angle_between(u, foot));
  }
  return Angle::from_radians(off).degrees();
}

inline double off_segment(Point<Part> p, Point<Part> a, Point<Part> b) {
  const Vec3 d = b - a;
  const double f = squared_length(d) > 0 ? std::clamp(dot(p - a, d) / squared_length(d), 0.0, 1.0) : 0.0;
  return distance(p, lerp(a, b, f));
}

struct Checked {
  double tip = 0, axis = 0, rapid_tip = 0, rapid_axis = 0, largest_turn = 0;
};

/// Samples every block at 64 places and holds tip and axis to the move's segment and arc; poses in order.
inline Checked check_densely(const ToolPath& path, const MachineModel& m, const tiltfeed::Setup& setup,
                             const JointPathOptions& options, const JointPath& joints) {
  Checked worst;
  const double slack = options.tolerance * kRapidToleranceFactor;
  EXPECT_EQ(joints.moves.at(0).move, 0u);
  EXPECT_EQ(joints.moves.at(0).seconds, 0.0);
  Joints at = joints.moves.at(0).joints;
  std::size_t next = 1;
  for (std::size_t move = 1; move < path.moves.size(); ++move) {
    const Pose &from = path.moves[move - 1].pose, &to = path.moves[move].pose;
    const bool rapid = path.moves[move].kind == MoveKind::kRapid;
    for (; next < joints.moves.size() && joints.moves[next].move == move; ++next) {
      const Joints q = joints.moves[next].joints;
      EXPECT_EQ(joints.moves[next].kind, path.moves[move].kind);
      EXPECT_FALSE(q == at) << "block " << next << " moves nothing";
      EXPECT_EQ(broken_limit(m, q), std::nullopt);
      for (const double value : {q.x, q.y, q.z})
        EXPECT_EQ(value, round_decimal(value, options.linear_decimals));
      for (const double value : {q.a, q.c}) EXPECT_EQ(value, round_decimal(value, options.rotary_decimals));
      worst.largest_turn = std::max(worst.largest_turn, std::abs(q.c - at.c));
      for (int i = 0; i <= 64; ++i) {
        const double f = i / 64.0, g = 1 - f;
        const Pose pose = forward(m, setup,
                                  {g * at.x + f * q.x, g * at.y + f * q.y, g * at.z + f * q.z,
                                   g * at.a + f * q.a, g * at.c + f * q.c});
        double& tip = rapid ? worst.rapid_tip : worst.tip;
        double& axis = rapid ? worst.rapid_axis : worst.axis;
        tip = std::max(tip, off_segment(pose.tip, from.tip, to.tip));
        axis = std::max(axis, off_arc(pose.axis, from.axis, to.axis));
      }
      at = q;
    }
    // Whatever was emitted or dropped: the move ends at its pose.
    const Pose end = forward(m, setup, at);
    EXPECT_LE(distance(end.tip, to.tip), rapid ? slack : options.tolerance) << "move " << move;
    EXPECT_LE(Angle::from_radians(angle_between(end.axis, to.axis)).degrees(), options.axis_tolerance)
        << "move " << move;
  }
  EXPECT_EQ(next, joints.moves.size());
  EXPECT_LT(worst.largest_turn, 180.0);
  EXPECT_LE(worst.tip, options.tolerance);
  EXPECT_LE(worst.axis, options.axis_tolerance);
  EXPECT_LE(worst.rapid_tip, slack);
  EXPECT_LE(worst.rapid_axis, options.axis_tolerance * kRapidToleranceFactor);
  // The report agrees with the independent samples, to the share that eight samples may miss, and to the
  // rounding of the start.
  EXPECT_LE(worst.tip, joints.report.max_tip_deviation * 1.1 + std::pow(10.0, -options.linear_decimals));
  EXPECT_LE(worst.axis, joints.report.max_axis_deviation * 1.1 + std::pow(10.0, -options.rotary_decimals));
  return worst;
}

inline Checked expect_good(const std::vector<Pose>& poses, const MachineModel& m, JointPath* out = nullptr,
                           const JointPathOptions& options = {}) {
  const ToolPath path = path_of(poses);
  const auto joints = to_joints(path, m, standing(), options);
  if (!joints) {
    ADD_FAILURE() << joints.error().message;
    return {};
  }
  if (out) *out = *joints;
  return check_densely(path, m, standing(), options, *joints);
}

inline std::vector<Pose> sampled(int count, const std::function<Pose(double)>& at) {
  std::vector<Pose> poses;
  for (int i = 0; i <= count; ++i) poses.push_back(at(static_cast<double>(i) / count));
  return poses;
}

inline double span(const JointPath& path, double Joints::*axis) {
  double low = 1e9, high = -1e9;
  for (const JointMove& move : path.moves) {
    low = std::min(low, move.joints.*axis);
    high = std::max(high, move.joints.*axis);
  }
  return high - low;
}

}  // namespace tiltfeed::joint_check
