#pragma once
// A part as the page draws it: float32 corners, the edges that are wrong, and what is to be said of it.

#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"

namespace tiltfeed::desk {

/// A unit that an STL may be in.
struct StlUnit {
  const char* word;
  double mm;
};
inline constexpr StlUnit kStlUnits[] = {{"mm", 1.0}, {"inch", 25.4}, {"m", 1000.0}};

/// The length of a unit, mm: one of kStlUnits, or a number of mm as a job may state it. Nothing where it is
/// neither.
std::optional<double> unit_length(const std::string& unit);

/// Parts of less or more than this in their longest direction were hardly meant, mm.
inline constexpr double kLeastPart = 5.0, kLargestPart = 1500.0;
/// Edges that are marked at most: more would hide the part.
inline constexpr std::size_t kMostEdges = 200'000;

struct PartView {
  std::vector<float> corners;  ///< nine for each facet of the file, in its order, mm
  /// Six for each edge that has not two facets that agree, as weld() and state() see the file.
  std::vector<float> edges;
  std::size_t bad_edges = 0;          ///< all of them, those beyond kMostEdges too
  pathgen::CheckedMesh checked;       ///< as the planner will repair it, with the default tolerance
  std::vector<std::string> warnings;  ///< of the file, then of the mesh
};

/// Errors: as read_stl() and check_mesh().
Result<PartView> view_part(const std::string& path, double unit_mm);

/// The units in which the part would have a common size, where it has none in `unit_mm`; else empty.
std::vector<StlUnit> likelier_units(const pathgen::Box& bounds, double unit_mm);

/// Writes corners, edges and the part's JSON object into files of `folder`: mesh.f32, edges.f32, part.json.
/// Errors: kIo; as view_part().
Result<void> write_part_view(const std::string& stl, const std::string& unit, const std::string& folder);

}  // namespace tiltfeed::desk
