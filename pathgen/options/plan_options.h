#pragma once
// What a job asks of the path: tool, axis, pattern, containment, accuracy, links.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "kinematics/basics/units.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/options/chosen_faces.h"
#include "pathgen/options/cutter.h"
#include "pathgen/options/fixtures.h"

namespace tiltfeed::pathgen {

enum class Direction { kOneWay, kZigzag };

enum class PatternKind {
  kRaster,   ///< passes side by side, straight in flat space
  kZLevel,   ///< contours at constant z', step_down apart
  kSplit,    ///< z-level where the surface is steeper than split_slope, raster elsewhere
  kContour,  ///< contour-parallel: the region's border, moved inwards by side_step again and again
  kSpiral,   ///< the same as one unbroken spiral from the border to the middle
  kRough,    ///< raster layers from the stock down to the part, step_down apart
  kPencil    ///< along the creases of the CL surface, where the tool touches the part at two places
};

/// How the distance of neighbouring passes is measured.
enum class StepMeasure {
  kFlat,     ///< in flat space: constant there, wider or narrower on the part
  kSurface,  ///< on the part: no two neighbouring passes are further apart than side_step
  kScallop,  ///< on the part: no ridge between two passes is higher than `scallop`
  kRidge     ///< by the ridges themselves: no ridge is higher than rows side_step apart leave somewhere, or
             ///< than `scallop`
};

struct Pattern {
  PatternKind kind = PatternKind::kRaster;
  Along along = Along::kX;
  Angle angle;  ///< of the passes, from `along` towards the other coordinate; raster and rough
  Direction direction = Direction::kZigzag;
  StepMeasure measure = StepMeasure::kFlat;
  double side_step = 0.0;  ///< mm
  double scallop = 0.0;    ///< mm; with StepMeasure::kScallop; with kRidge where above 0
  double optimise_scallop =
      0.0;                 ///< mm; of rows that are laid anew for the shortest time; 0: as the job's own
  double step_down = 0.0;  ///< mm of z'; z-level, split, rough
  bool climb = true;       ///< z-level, contour, spiral: material right of the feed
  Angle split_slope = Angle::from_degrees(45.0);  ///< of the surface against the plane across the axis
  /// Pencil: the least angle between the surface's normals on both sides of a crease. Facets of a round
  /// hollow meet at less.
  Angle crease_angle = Angle::from_degrees(10.0);
};

/// No limit where not set.
struct Interval {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool contains(double v) const { return v >= low && v <= high; }
  bool bounded() const {
    return low > -std::numeric_limits<double>::infinity() || high < std::numeric_limits<double>::infinity();
  }
};

/// Where the tool's axis line may be, in the axis mode's own coordinates: Theta and Phi in rad (point,
/// circle), x in mm and Theta in rad (line), x and y in mm (fixed); `height`: distance from the point, line
/// or circle of the cutter location (mm), or z' in the mode fixed. With the axis free: x, y and z (mm) of the
/// cutter location, and no boundary.
struct Containment {
  Interval first, second, height;
  /// A closed polygon in (first, second), at least three corners, either way round; empty: none.
  std::vector<std::array<double, 2>> boundary;
};

/// What is done where a part of the tool would come nearer than its clearance.
enum class Reaction {
  kTrim,     ///< those places are left out, and reported
  kRetract,  ///< the tool is raised along its axis until it is clear, and that is reported
  kTilt,     ///< the tool leans about its ball until it is clear; what no lean clears is left out
  kReport    ///< the path stays as it is; the report says where
};
struct StandOff {
  double clearance = 0.0;  ///< mm
  Reaction reaction = Reaction::kTrim;
};

/// By how much the tool may lean from a predefined axis where a guard's reaction is kTilt; ball and
/// taper_ball.
struct Lean {
  Angle limit;     ///< largest angle to the axis that the mode says, below 90 degrees; 0: none
  Angle max_turn;  ///< of the lean, per mm of the CL point's way on a pass
};

/// How fast the machine moves where nothing is cut, about: by these the order of passes is chosen.
struct RapidRates {
  struct Axis {
    double velocity = 0.0, acceleration = 0.0;  ///< mm and degrees; per s, per s^2
  };
  Axis linear{250.0, 2000.0}, tilt{60.0, 600.0}, table{120.0, 600.0};
};

struct LinkingOptions {
  double clearance = 0.0;      ///< of the clearance surface over the highest CL point, mm
  double approach = 0.0;       ///< the last part of an approach, travelled at plunge feed, mm
  double join_distance = 0.0;  ///< passes whose ends are at most this far apart are joined on the surface, mm
  double lead_radius = 0.0;  ///< of tangential arcs into and out of each pass, mm; 0: straight down the axis
  /// Closed rows that are cut the same way round, one after the other without a stop, before the next goes
  /// back; 0: each begins where it lies.
  std::uint32_t rounds = 0;
  RapidRates rapid{};
};

/// What the tool axis should be where it is free, and how the part is sliced.
struct FreeAxis {
  /// Of the stacks of slicing planes, unit. Each place of the CL surface is cut by the stack whose normal is
  /// the furthest from the surface's.
  std::vector<Vec3> plane_normals;
  Angle lead;              ///< wished lean from the surface normal along the feed: the tip trails
  Angle lean;              ///< wished lean from the surface normal, to the left of the feed
  double smoothing = 0.0;  ///< wished directions are means over this length of the pass, mm
  Angle max_turn;          ///< of the tool axis on a pass, per mm of the CL point's way
};

/// How the fixed directions of indexed machining are chosen.
struct IndexedAxis {
  std::uint32_t most_directions = 6;  ///< at most kMostDirections (pathgen/indexed/index_order.h)
  /// Share of the area within reach of any direction that is enough: no direction is added for the rest.
  double coverage = 0.995;
  /// Of that area; a direction that reaches less which no other chosen one does is not worth its turn.
  double least_gain = 0.005;
  /// A direction counts for a place only if it leans no further than this from the surface's normal.
  Angle steepest = Angle::from_degrees(75.0);
};

struct EarlierCut;
class BlankSolid;

struct PlanOptions {
  std::string name;  ///< of the part
  Cutter cutter;
  AxisFrame axis;
  Lean lean;            ///< neither with AxisMode::kFree nor kIndexed
  FreeAxis free;        ///< with AxisMode::kFree
  IndexedAxis indexed;  ///< with AxisMode::kIndexed
  Pattern pattern;
  Containment containment;
  std::shared_ptr<const ChosenFaces> only_faces;  ///< null: all of the part is machined
  double tolerance = 0.01;          ///< largest gouge, and largest gap where contact is meant, part space, mm
  double allowance = 0.0;           ///< stock left on the part, along its normal, mm
  double radial_stock = 0.0;        ///< stock left besides, square to the tool axis, mm
  double axial_stock = 0.0;         ///< stock left besides, along the tool axis, mm
  double max_point_distance = 0.0;  ///< between two points of a pass, mm; 0: no limit
  Angle max_angle_step;    ///< of the tool axis between two points of a pass; 0: no limit but the tolerance's
  double smoothing = 0.0;  ///< least radius of a pass's concave corners, mm; 0: none
  bool find_rest_material = false;  ///< say what stays uncut, and what the passes leave
  StandOff shank, holder;
  std::shared_ptr<const Fixtures> fixtures;  ///< null: none
  FixtureRoom fixture_room;
  LinkingOptions links;
  /// Only where the operations before leave more than this on the part, mm; 0: everywhere.
  double rest_more_than = 0.0;
  bool rest_everywhere = false;  ///< all passes are cut all the same, not looking where that is
  std::vector<std::shared_ptr<const EarlierCut>> earlier;  ///< those operations, in their order
  /// What the job is cut from; null: nobody says. Rapids across the part go over it.
  std::shared_ptr<const BlankSolid> blank;
  bool from_blank = false;  ///< is this the first operation, which finds all of the blank?
  Feed cut_feed, plunge_feed;
  Vec3 up{0, 0, 1};  ///< the table's axis in part directions, unit
  Angle tilt_max =
      Angle::from_degrees(180.0);  ///< largest angle of the tool axis to `up`; the rest is left out
};

/// May the tool lean anywhere?
inline bool may_lean(const PlanOptions& o) {
  return o.lean.limit.radians() > 0.0 &&
         (o.shank.reaction == Reaction::kTilt || o.holder.reaction == Reaction::kTilt);
}
/// An operation before: what it was asked for, and how its tool moves.
struct EarlierCut {
  PlanOptions options;
  std::vector<Move> moves;
};

}  // namespace tiltfeed::pathgen
