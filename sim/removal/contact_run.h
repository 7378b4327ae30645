#pragma once
// What a run of steps against the part keeps at hand: internal to contact*.cpp.

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/removal/contact.h"
#include "sim/removal/facet.h"
#include "sim/removal/four_sheets.h"
#include "sim/removal/sheet.h"

namespace tiltfeed::sim {

// A ball that may be too deep is looked at along so many straight pieces of its way: what they stray is the
// square of this less than what the step does.
inline constexpr int kWays = 4;
// Groups end where they leave a cube of so many radii.
inline constexpr double kCubeRadii = 4.0;
// A core is looked at in so many stretches at most.
inline constexpr std::size_t kMostStretches = 3;

/// A stretch of the core, pushed along the way of a group.
struct Contact::Stretch {
  Sheet sheet;
  Point<Part> foot;
  Vec3 way, core;
  double wide = 0.0;  ///< how far any piece of it may be from the sheet, mm

  Stretch(Point<Part> the_foot, Vec3 the_way, Vec3 the_core)
      : sheet(the_foot, the_way, the_core), foot(the_foot), way(the_way), core(the_core) {}
  std::array<Point<Part>, 2> lower() const { return {foot, foot + way}; }
  std::array<Point<Part>, 4> corners() const { return {foot, foot + way, foot + core, foot + way + core}; }
};

/// Steps in a row, near each other.
struct Contact::Group {
  const SweptStep *begin = nullptr, *end = nullptr;
  std::size_t first_view = 0, end_view = 0;  ///< of Run::views
  Vec3 axis, along;                          ///< mean axis; unit, the way across it, or zero
  double turn = 0.0;                         ///< of any axis from the mean one
  double step_stray = 0.0, step_turn = 0.0;  ///< the largest of the steps', mm
  double stray = 0.0;                        ///< of the core's lower end from its straight way, mm
  double slack = 0.0;                        ///< the largest of the views', mm
  std::array<bool, 2> has{};                 ///< feed moves, rapids
  std::vector<Stretch> stretches;            ///< of the core, from below
};

/// Four groups of a cluster side by side; what is missing to four is filled up with the last of them.
struct Contact::Four {
  std::array<const Group*, 4> groups{};
  unsigned filled = 0;  ///< a bit for each
  FourSheets ball;      ///< the way of the core's lower end
  std::array<FourSheets, kMostStretches> core;
  LaneVec3 axis{};
  Lanes turn{}, off{}, far{};  ///< of above_ball()
  Lanes deep{};                ///< what the straight way of a step must be below to be too deep

  void set(int lane, const Group& group, Point<Part> origin, double radius);
  Lanes above_ball(const FacetLanes& facet, float most) const;
};

/// Groups near each other, which look for patches together.
struct Contact::Cluster {
  std::vector<Stretch> hull;        ///< what the groups sweep is within `wide` of these
  std::vector<std::size_t> groups;  ///< of Run::groups
};

/// A patch that a cluster may do something to, and by which stretches of its hull: bit k for that of number
/// k.
struct Contact::Found {
  std::uint32_t patch = 0, stretches = 0;
};

/// By what part of a tool: by the ball at its core's lower end, by the rest of the core.
struct Contact::By {
  bool ball = false, side = false;
  explicit operator bool() const { return ball || side; }
};

/// A group that may do something to a patch.
struct Contact::Candidate {
  const Group* group = nullptr;
  By takes, touches;         ///< it may lower probes; it may be too deep
  double least = kInfinity;  ///< not more than the value of any probe, mm
};

/// A patch, or the part of it that holds some of its probes, as a group sees it.
struct Contact::Seen {
  Point<Part> middle;
  Vec3 normal;
  std::uint32_t patch = 0;
  double radius = 0.0;             ///< mm
  double rise = 0.0;               ///< how far it reaches along the tool's axis from its middle, mm
  double offset = 0.0;             ///< of its plane, moved by the tool's radius
  bool faces = false;              ///< the tool's axis points away from it in all of the group
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
  /// Of all that a core so long passes, straight.
  std::array<Point<Part>, 4> corners(double core) const {
    return {from, to, from + step->from.axis * core, to + step->to.axis * core};
  }
  std::vector<Pose> ways;   ///< ends of pieces of the step, once they are wanted
  std::vector<Pose> looks;  ///< near enough to each other, once they are wanted
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
  std::vector<Group> groups;
  std::vector<Cluster> clusters;
  std::vector<Found> found_patches;   ///< of one cluster
  std::vector<Candidate> candidates;  ///< of one patch
  std::vector<Four> fours;            ///< of the cluster at hand
  Point<Part> origin;                 ///< of the fours
  std::vector<View> views;            ///< of all groups, in order
  std::vector<Probes::Live> live;     ///< likewise
  std::vector<Meeting> balls, sides;  ///< of one candidate
  std::vector<Watch> watches;
  std::vector<Pose> poses;  ///< of a step's looks
  double tolerance = 0.0;
  std::array<std::atomic<double>, 2>* deepest = nullptr;  ///< of all runs

  /// What is not deeper does not matter, of any move of the group, mm.
  double allowed(const Group& group) const {
    double most = tolerance;
    for (std::size_t k = 0; k < group.has.size(); ++k)
      if (group.has[k]) most = std::min(most, known(k));
    return most;
  }
  double allowed(const View& view) const { return std::min(known(view.rapid ? 1 : 0), tolerance); }
  /// What is not deeper is not the deepest; of what others have found what is as deep may be it, so that the
  /// result does not depend on who comes first.
  double known(std::size_t rapid) const {
    const double others = (*deepest)[rapid].load(std::memory_order_relaxed) - kBoundSlack;
    return std::max(found.worst[rapid].depth, others);
  }
  /// Of equally deep ones the earliest move's counts, then the least patch: the order does not matter.
  static bool deeper(const Overlap& a, const Overlap& b) {
    return a.depth != b.depth ? a.depth > b.depth : a.move != b.move ? a.move < b.move : a.patch < b.patch;
  }
  void report(View& view, const Overlap& overlap) {
    const std::size_t rapid = view.rapid ? 1 : 0;
    if (deeper(overlap, found.worst[rapid])) found.worst[rapid] = overlap;
    double others = (*deepest)[rapid].load(std::memory_order_relaxed);
    while (others < overlap.depth &&
           !(*deepest)[rapid].compare_exchange_weak(others, overlap.depth, std::memory_order_relaxed)) {
    }
    if (deeper(overlap, view.deepest)) view.deepest = overlap;
  }
};

}  // namespace tiltfeed::sim
