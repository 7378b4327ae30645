#pragma once
// In which order and direction runs with axes of their own are travelled, by the time of the ways between
// them. (L8) in pathgen/linking/README.md.

#include <cstdint>
#include <vector>

#include "pathgen/linking/link_options.h"
#include "pathgen/linking/rapid_time.h"

namespace tiltfeed::pathgen {

/// A run as its links see it: both ends in contact.
struct RunEnds {
  Pose first, last;
};

/// A run, and whether it is travelled from back to front.
struct OrderedRun {
  std::uint32_t run = 0;
  bool reversed = false;
  bool operator==(const OrderedRun&) const = default;
};

/// How long ways between runs take, about. Properties: 1 Both senses of a way take the same time. 2 None is
/// negative.
class LinkTime {
 public:
  struct Options {
    RapidRates rapid;
    Vec3 up{0, 0, 1};           ///< the table's axis, unit
    Point<Part> centre;         ///< of the sphere that ways lead over
    double radius = 0.0;        ///< its, mm
    double lift = 0.0;          ///< of a short way over the part, mm
    double short_way = 0.0;     ///< so far, mm, short ways are tried
    Angle short_turn;           ///< and with the axis turning by no more
    double plunge_seconds = 0;  ///< at the end of each way
  };
  explicit LinkTime(const Options& options) : o_(options) {}

  /// Of the way from a place in contact to another, s.
  double between(const Pose& from, const Pose& to) const;
  /// From a place on the sphere, s.
  double from_above(Point<Part> from, Vec3 axis, const Pose& to) const;
  /// Of the rapids and plunges of a path, s: rapids go on without a stop where they do not turn back.
  double of(const std::vector<Move>& moves) const;

 private:
  RotaryTurn turn(Vec3 from, Vec3 to) const { return rotary_turn(from, to, o_.up); }
  double rapid(double way) const { return rest_to_rest(way, o_.rapid.linear); }
  double up_to_sphere(const Pose& at, Point<Part>& on_sphere) const;

  const Options o_;
};

/// An order of short ways: from the start above to the nearest run, on to the nearest that is left (in time,
/// of those near in space), and then by exchanges of runs while they save time: stretches turned round
/// (2-opt), up to three runs moved (Or-opt). Properties: 1 Each run once; backwards only where `reversible`.
/// 2 The sum of the ways is no longer than before the exchanges. 3 The same for the same runs. The work is
/// n^2 at most.
std::vector<OrderedRun> order_runs(const std::vector<RunEnds>& runs, bool reversible, const LinkTime& time,
                                   Point<Part> start, Vec3 start_axis);

/// The sum of the ways of an order, s.
double time_of_order(const std::vector<OrderedRun>& order, const std::vector<RunEnds>& runs,
                     const LinkTime& time, Point<Part> start, Vec3 start_axis);

/// More runs than these are not put in order by time: the nearest follows.
inline constexpr std::size_t kMostOrderedRuns = 5000;

}  // namespace tiltfeed::pathgen
