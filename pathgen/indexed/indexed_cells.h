#pragma once
// The part's surface in small cells, and from which directions the tool reaches each of them.

#include <cstdint>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/progress/watch.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

struct SurfaceCell {
  Point<Part> place;         ///< its middle
  Vec3 normal;               ///< unit, of its facet
  double area = 0.0;         ///< mm^2
  std::uint32_t facet = 0;   ///< of the mesh
  std::uint32_t source = 0;  ///< facet of the STL file
};

/// Every facet as one cell, or cut into equal triangles where its longest edge is longer than `size` (mm).
std::vector<SurfaceCell> make_cells(const Mesh& mesh, double size);
/// Those of the faces that alone are to be machined; all where none are chosen.
std::vector<SurfaceCell> only_chosen(std::vector<SurfaceCell> cells, const PlanOptions& options);
/// `count` of them or fewer, spread evenly over the area; each stands for as much area as the others.
std::vector<SurfaceCell> sample_cells(const std::vector<SurfaceCell>& cells, std::uint32_t count);

struct Contact {
  Point<Part> place;
  std::uint32_t facet = 0;  ///< of the mesh
};

class CellReach {
 public:
  /// All must outlive the object. Requires: a ball or taper-ball cutter.
  CellReach(const SweptTool& tool, const PlanOptions& options) : tool_(tool), options_(options) {}

  const SweptTool& tool() const { return tool_; }
  /// Does the ball fit where it touches the middle of the cell?
  bool seats(const SurfaceCell& cell) const;
  /// Where a ball there touches the surface, within `gap` (mm).
  std::optional<Contact> contact(Point<Part> centre, double gap) const;
  /// Can the tool touch the middle of the cell with its axis along `direction`, and be drawn out along it,
  /// not leaning further from the normal than IndexedAxis::steepest nor further from `up` than tilt_max?
  /// Requires: seats(cell). `hint` as SweptTool::stop. Safe to call from several threads.
  bool reaches(const SurfaceCell& cell, Vec3 direction, std::uint32_t& hint) const;
  /// The same but for the tilt limit, and with `parts` of the tool: kCutterOnly to kWithFixtures.
  bool clears(const SurfaceCell& cell, Vec3 direction, std::uint32_t& hint, int parts) const;

 private:
  const SweptTool& tool_;
  const PlanOptions& options_;
};

/// sets[d][c]: does direction d reach cell c? In parallel; the same for any number of threads. When the user
/// stops it, not all is asked.
std::vector<std::vector<std::uint8_t>> reach_sets(const CellReach& reach,
                                                  const std::vector<SurfaceCell>& cells,
                                                  const std::vector<Vec3>& directions,
                                                  const ReportShare& report = {});

}  // namespace tiltfeed::pathgen
