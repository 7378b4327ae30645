#pragma once
// What linking is told, and what it makes.

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/basics/units.h"
#include "pathgen/envelope/pass.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

/// Which order of the passes is sought.
enum class PassOrder {
  kGiven,    ///< slice by slice
  kRegions,  ///< region by region where that saves air, else slice by slice
  kTimed,  ///< that of them, or of regions put in order by the time between them, which takes the least time
};

class Envelope;
struct ClField;

/// How a tool that leans from the axis field at an end of a pass comes there and away: (L7).
struct LeanedEnd {
  Point<Part> top;   ///< of the reference, drawn back along the tool's own axis
  Point<Flat> over;  ///< on the clearance surface, where it stands upright again
};
struct LeanedWays {
  const ClField* field = nullptr;  ///< on which passes lie that lean: shank and holder are not in it
  Envelope* envelope = nullptr;    ///< of it
  /// Of an end of a pass; nothing where it does not lean.
  std::function<std::optional<LeanedEnd>(const EnvelopePoint&)> end{};
  /// How far over it, along its axis, a rapid ends, mm.
  std::function<double(const EnvelopePoint&)> rapid_end{};
  /// The points of a join with their leans; nothing where there is none.
  std::function<std::optional<Pass>(const EnvelopePoint& a, const Pass& between, const EnvelopePoint& b)>
      join{};
};

struct Linking {
  Direction direction = Direction::kZigzag;
  double reference_height = 0.0;  ///< of the CL reference over the tip, mm
  double clearance_z = 0.0;       ///< z' of the clearance surface, mm
  double clearance = 0.0;         ///< of the clearance surface over what it clears, mm
  double approach = 0.0;          ///< last part of an approach, at plunge feed, mm
  double join_distance = 0.0;     ///< ends of passes at most this far apart may be joined, mm; 0: none
  double lead_radius = 0.0;       ///< of the arcs into and out of a pass, mm; 0: none
  double thinning = 0.003;        ///< a join's points that a move passes this closely are dropped, mm
  double plunge_ratio = 1.0;      ///< cutting feed over plunge feed
  double cut_speed = 0.0;  ///< of the tip along a join, mm/s; 0: a fifth of that on rapids, whatever it is
  RapidRates rapid{};      ///< with cut_speed
  Vec3 up{0, 0, 1};        ///< the table's axis in part directions, unit
  Angle tilt_max = Angle::from_degrees(180.0);  ///< largest angle of the tool axis to `up`
  PassOrder order = PassOrder::kRegions;
  /// Closed rows that follow each other are cut so many the same way round, each begun where the one before
  /// ends, before it goes back; one way it never does. 0 and 1: each begins where it lies.
  std::uint32_t rounds = 0;
  /// Are shank and holder known at this place, that is, not lower than passes come? Asked on the way of joins
  /// and leads. Empty: everywhere.
  std::function<bool(Point<Flat>)> known{};
  /// May a point be cut? It is asked of the points of joins. Empty: all may.
  std::function<bool(const EnvelopePoint&)> allowed{};
  /// And a straight move between two of them? Empty: any.
  std::function<bool(const EnvelopePoint&, const EnvelopePoint&)> straight{};
  const LeanedWays* leaned = nullptr;  ///< null: no pass leans
  /// The z' down to which the tool comes free of stock over (x', y'), at least the z' that is given. Empty:
  /// no stock is higher than the approach over the part.
  std::function<double(Point<Flat>, double)> free_from{};
  /// Would what of the tool is beyond its column meet the blank on that way? Empty: columns do not end.
  std::function<bool(const Pose&, const Pose&)> in_blank{};
  /// When the user stops it, the moves are not all there.
  ReportShare report{};
};

struct Linked {
  std::vector<Move> moves;
  std::uint64_t skipped_passes = 0;  ///< to which every way hits the part on the opposite wall
  std::uint64_t tilted_passes = 0;   ///< to which every clear way tilts the axis further than tilt_max
  std::uint64_t retracts = 0;        ///< to the clearance surface, the last one included
  std::uint64_t joins = 0;           ///< passes that start where a join on the envelope ends
  std::uint64_t closed_rows = 0;     ///< passes that go all the way round
  std::uint64_t leads = 0;           ///< arcs
  std::uint64_t straight_ends = 0;   ///< ends that were to have an arc but had no room for it
  double air_length = 0.0;           ///< of the tip over rapid and plunge moves, mm
};

/// The pose of the tool with its CL reference at `reference`.
inline Pose pose_at(Point<Part> reference, Vec3 axis, double reference_height) {
  return {reference - axis * reference_height, axis};
}

}  // namespace tiltfeed::pathgen
