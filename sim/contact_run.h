#pragma once
// What a run of steps against the part keeps at hand: internal to contact*.cpp.

#include <algorithm>
#include <vector>

#include "sim/contact.h"

namespace tiltfeed::sim {

// A ball that may be too deep is looked at along so many straight pieces of its way: what they stray is the
// square of this less than what the step does.
inline constexpr int kWays = 4;

/// A patch that the steps of a group may come near to.
struct Contact::Candidate {
  Point<Part> middle;
  Vec3 normal;
  double radius = 0.0;  ///< mm
  double rise = 0.0;    ///< how far it reaches along the tool's axis from its middle, mm
  double offset = 0.0;  ///< of its plane
  bool faces = false;   ///< the tool's axis points away from it in all of the group
  std::uint32_t patch = 0;
  double first = 0.0, last = 0.0;  ///< of the group's direction: where the core must be to matter, mm
};

/// A step of a group.
struct Contact::View {
  View(const SweptStep& the_step, const BallWay& ball) : step(&the_step), way(ball) {}

  const SweptStep* step;
  Point<Part> from, to;  ///< of the core's lower end
  BallWay way;
  double slack = 0.0;              ///< mm that a height over the ball may be off
  double first = 0.0, last = 0.0;  ///< where its core is along the group's direction, mm
  bool rapid = false;
  Overlap deepest;
  std::vector<Pose> ways;  ///< ends of pieces of the step, once they are wanted
};

/// What a step may do to a patch.
struct Contact::Meeting {
  View* view = nullptr;
  double lowest = 0.0;            ///< not more than the value of any probe, mm
  double up = 0.0, up_end = 0.0;  ///< sine of the axis over the patch, at both ends
};

/// What is known of a part of the tool that is far from contact, or in it.
struct Contact::Watch {
  double free = -kInfinity;  ///< it is at least so far from the part, mm
  int in_contact = 0;        ///< looks that only ask whether it is too deep
};

struct Contact::Run {
  Contacts found;
  std::vector<Candidate> candidates;
  std::vector<View> views;
  std::vector<Meeting> balls, sides;  ///< of one candidate
  std::vector<Watch> watches;
  std::vector<Pose> poses;  ///< of a step's looks
  double tolerance = 0.0;

  /// What is not deeper does not matter, mm.
  double allowed(const View& view) const { return std::min(found.worst[view.rapid ? 1 : 0], tolerance); }
  void report(View& view, const Overlap& overlap) {
    double& worst = found.worst[view.rapid ? 1 : 0];
    worst = std::max(worst, overlap.depth);
    if (overlap.depth > view.deepest.depth) view.deepest = overlap;
  }
};

}  // namespace tiltfeed::sim
