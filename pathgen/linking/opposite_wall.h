#pragma once
// The opposite wall: an axis line may run on past the point, line or circle (inside work), or past the axis
// of Theta (inner half of a circle, outside work), into a part of the flat space that is not its own column.
// What of the tool is there is checked by rays. (F1) in pathgen/linking/README.md.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/envelope/envelope.h"
#include "pathgen/linking/shank_collision.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/watch.h"
#include "pathgen/surface/column_ends.h"

namespace tiltfeed::pathgen {

/// How far any point of the tool may be from where a rapid says that it is, mm: the axes may move tip and
/// axis off the way, and it is looked at in steps.
double stray_of_rapids(double tolerance);

class OppositeWall {
 public:
  /// `clearance_z`: z' of the clearance surface, to which the tool must be able to retract.
  OppositeWall(const Mesh& mesh, const Deformation& deformation, const PlanOptions& options,
               double clearance_z);

  /// Cuts out of the passes every place from where the tool could not retract without hitting the opposite
  /// wall. Returns how many points, a stretch between two as one. When the user stops it, places are left
  /// that should not be.
  std::uint64_t trim(std::vector<std::vector<Pass>>& lines, const ReportShare& report = {});

  /// Could the tool, standing at that point, not retract without hitting the opposite wall?
  bool keeps_off(const EnvelopePoint& stand) { return keeps_off(tool_, stand); }

  /// Is a straight way from one pose to the next free of hits on the opposite wall?
  bool travel_clear(const Pose& from, const Pose& to) { return is_clear(tool_, from, to); }
  /// And with room for what the axes may stray on a rapid, and for half of the approach, which may stand on
  /// the part as stock? Where the axis stands the axes do not stray.
  bool rapid_clear(const Pose& from, const Pose& to) {
    return is_clear(from.axis == to.axis ? over_stock_ : strayed_, from, to);
  }
  /// The z' from which on upwards the tool, grown by the approach, comes clear of the opposite wall over
  /// (x', y'): at least `to`, at most the clearance surface.
  double rapid_end(Point<Flat> place, double to);

 private:
  /// A piece of the tool as a cylinder: heights over the CL reference, mm.
  struct Cylinder {
    const Mesh* mesh = nullptr;  ///< the part's, or the fixtures'
    double from = 0.0, to = 0.0, radius = 0.0;
    double margin = 0.0;                                ///< of the mesh's rays, mm
    mutable std::unique_ptr<ShankCollision> clearance;  ///< made when first needed
  };
  using Tool = std::vector<Cylinder>;
  void add_tool(const PlanOptions& options, const Mesh& mesh, Tool& tool);
  Tool tool_of(const PlanOptions& options);
  Point<Part> reference_of(const Pose& pose) const;
  bool is_astray(const Pose& pose) const;
  bool is_clear(Tool& tool, const Pose& from, const Pose& to) const;
  bool stands_in_part(Tool& tool, const Pose& pose) const;
  bool keeps_off(Tool& tool, const EnvelopePoint& stand) const;
  double travel_from(const EnvelopePoint& p) const;
  double steps_of(Point<Part> from, Vec3 from_axis, Point<Part> to, Vec3 to_axis) const;
  /// Of a move that the opposite wall breaks: the last clear place of its start, the first of its end.
  struct Stretch {
    bool broken = false;
    std::optional<EnvelopePoint> before, behind;
  };
  std::uint64_t trim(std::vector<Pass>& passes, Watch& watch);
  Stretch clear_of(const EnvelopePoint& from, const EnvelopePoint& to, bool starts, bool ends);
  bool approaches(const AxisLine& line, Point<Flat> place) const;
  bool blocked(const Tool& tool, Point<Part> reference, Vec3 axis, double column, double travel) const;
  static ShankCollision& clearance_of(const Cylinder& c);
  void note_ends(const Mesh& mesh, double radius);
  double off_end(const Mesh& mesh, Point<Part> end) const;
  bool stands_in_wall(const Cylinder& c, Point<Part> reference, Vec3 axis, double column,
                      double travel) const;

  bool beyond_part(Point<Part> from, Point<Part> to, double radius) const;

  const Mesh& mesh_;
  Point<Part> low_, high_;  ///< corners of the box round part and fixtures
  const Deformation& map_;
  Tool tool_, strayed_;  ///< as it is, and grown by what rapids stray and half of the approach
  Tool over_stock_;      ///< grown by half of the approach
  Tool approaching_;     ///< grown by the approach
  Tool between_;         ///< smaller by what straight moves may leave: a move that runs in contact is clear
  std::map<const Mesh*, ColumnEnds>
      ends_;            ///< facets that some column's end is nearer to than the tool is wide
  double reach_ = 0.0;  ///< of the tool's upper end over the CL reference, mm
  double clearance_z_, reference_height_, step_;
};

}  // namespace tiltfeed::pathgen
