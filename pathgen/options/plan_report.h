#pragma once
// What a plan tells of itself: for the user's report and for the tests.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/options/rest_reason.h"
#include "pathgen/progress/stages.h"

namespace tiltfeed::pathgen {

/// Additional results of AxisMode::kFree.
struct FreeReport {
  std::uint64_t cl_points = 0;    ///< points of the CL surface at which a direction was sought
  std::uint64_t directions = 0;   ///< directions tested against the part, moves and links included
  double cl_length = 0.0;         ///< of the slices of the CL surface, mm
  double unreached_length = 0.0;  ///< of that, left out as no direction is admissible, mm
  std::uint64_t breaks = 0;       ///< of passes, where the direction must jump
  std::uint64_t short_links = 0;  ///< between passes, at the clearance over the surface
  struct Facet {
    std::uint32_t facet = kNoFacet;  ///< of the STL file
    RestReason why = RestReason::kCutter;
  };
  std::vector<Facet> unreached;  ///< facets touched where a slice was left out, ascending, each once
};

/// What the mode indexed chose, by places spread evenly over the part's surface.
struct IndexedReport {
  struct Direction {
    Vec3 axis;           ///< unit
    double alone = 0.0;  ///< share of the surface that of the chosen ones only this one reaches
  };
  std::vector<Direction> directions;  ///< in the order of machining
  double reached = 0.0;               ///< share of the surface that they reach
  double reachable = 0.0;  ///< by any direction that was asked: no number of fixed directions reaches more
};

struct RestFacet {
  std::uint32_t facet = 0;  ///< of the STL file
  RestReason why = RestReason::kCutter;
  double share = 0.0;  ///< of the facet's area, above 0; over pieces no larger than the cutter's radius
  std::uint32_t mesh_facet = 0;  ///< of the mesh that is planned, which repair may have cut up
};

/// What the passes leave between them of places that the tool reaches.
struct BetweenPasses {
  /// What the job lets them leave, tolerance included, mm; 0: it does not say, and nothing is looked for.
  double limit = 0.0;
  double most = 0.0;               ///< that they leave at most, mm; at least a quarter of the limit
  bool never = false;              ///< no pass comes near there, and `most` is only the least that is left
  std::uint32_t facet = kNoFacet;  ///< of the STL file, there
  Point<Part> place;
  double area = 0.0;   ///< on which they leave more than the limit, mm^2
  double walls = 0.0;  ///< what they leave of steeper walls that the tool reaches, where over the limit, mm^3
};

struct RestReport {
  std::vector<RestFacet> facets;  ///< that face the tool, ascending
  std::uint64_t away = 0;         ///< facets turned away from the tool, not among them
  double area = 0.0;              ///< uncut but for walls, mm^2
  double wall_area = 0.0;         ///< uncut walls, mm^2
  double facing_area = 0.0;       ///< of all that faces the tool, mm^2
  BetweenPasses between;
  std::vector<double> fixture_area;  ///< that each fixture keeps the tool from, mm^2
};

/// Where the tool leans from a predefined axis, as guards ask.
struct LeanReport {
  double length = 0.0;  ///< of the passes with a lean, mm
  double left = 0.0;    ///< of the passes left out, as no lean clears them or as it would turn too fast, mm
  Angle largest;        ///< lean
};

/// What a fixture keeps the tool from.
struct KeptByFixture {
  std::string name;
  std::uint64_t points = 0;  ///< left out of passes, before thinning; with the axis free, of slices
  Point<Part> place;         ///< the first of them
  double area = 0.0;         ///< mm^2, with PlanOptions::find_rest_material in one axis field
};

/// What the operations before leave, where the tool's axis faces the part.
struct RestBefore {
  double more_than = 0.0;  ///< PlanOptions::rest_more_than, mm
  double area = 0.0;       ///< on which more is left, mm^2
  double most = 0.0;       ///< mm; no more than the smallest radius of the cutters is told
  double whole = 0.0;      ///< length of the passes before all else was left out, mm; 0: not known
  bool all_cut = false;    ///< nothing was left out, as PlanOptions::rest_everywhere asks
};

struct PlanReport {
  std::uint64_t facets = 0;
  std::uint64_t passes = 0;                     ///< unbroken runs of cutting moves
  std::uint64_t slice_points = 0;               ///< envelope points before thinning
  std::uint64_t points = 0;                     ///< cutting moves of the path
  std::uint64_t retracts = 0;                   ///< to the clearance surface, the last one included
  std::uint64_t joins = 0;                      ///< passes begun from the one before, on the surface
  std::uint64_t closed_rows = 0;                ///< of these, rows that go all the way round
  double cut_length = 0.0, rapid_length = 0.0;  ///< of the tip, mm
  double pattern_length = 0.0;                  ///< of the passes before places were left out, mm
  double ridge = 0.0;                           ///< with StepMeasure::kRidge what is allowed between rows, mm
  std::optional<FreeReport> free;               ///< with the axis free
  std::optional<IndexedReport> indexed;         ///< with fixed directions
  std::optional<LeanReport> lean;               ///< where a guard lets the tool lean and something comes near
  std::optional<RestReport> uncut;              ///< with PlanOptions::find_rest_material, in one axis field
  std::optional<BetweenPasses> between;         ///< the same where each place has its own axis: free, indexed
  std::optional<RestBefore> rest;               ///< with PlanOptions::rest_more_than
  std::vector<KeptByFixture> fixtures;          ///< those that keep the tool from something
  std::vector<std::string> warnings;
  std::vector<StageTime> times;
};

struct Plan {
  ToolPath path;
  PlanReport report;
};

}  // namespace tiltfeed::pathgen
