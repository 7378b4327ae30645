#pragma once
// A part as the page draws it: float32 corners, the edges that are wrong, and what is to be said of it.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/mesh.h"
#include "pathgen/part_file/part_model.h"

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

/// Which part, and what of it.
struct PartAsked {
  std::string path;
  std::string unit = "mm";  ///< of a mesh file, as unit_length() takes it; others state their own
  std::vector<std::string> bodies = {};  ///< that are drawn, by name; empty: all
  std::vector<std::string> avoid = {};   ///< names and colours of faces that a job asks to keep off
  double deviation = 0.002;              ///< of facets from surfaces (STEP, IGES), mm
};

struct PartView {
  std::vector<float> corners;          ///< nine for each facet that is drawn, in the order of the file, mm
  pathgen::PartModel model;            ///< all bodies and faces of the file, without facets
  std::vector<std::uint32_t> face_of;  ///< of each facet that is drawn; empty: a mesh file
  std::vector<bool> drawn;             ///< by body
  /// Six for each edge that has not two facets that agree, as weld() and state() see the file.
  std::vector<float> edges;
  std::size_t bad_edges = 0;          ///< all of them, those beyond kMostEdges too
  pathgen::CheckedMesh checked;       ///< as the planner will repair it, with the default tolerance
  std::vector<std::string> warnings;  ///< of the file, then of the mesh
};

/// Properties: the facets that are drawn are those that config::read_part_file() reads of these bodies.
/// Errors: as read_part_file() and check_mesh(); kUsage: no such unit. `listed`: is told of the model before
/// any error about the bodies that are asked for.
Result<PartView> view_part(const PartAsked& asked,
                           const std::function<Result<void>(const pathgen::PartModel&)>& listed = {});

/// The units in which the part would have a common size, where it has none in `unit_mm`; else empty.
std::vector<StlUnit> likelier_units(const pathgen::Box& bounds, double unit_mm);

/// Writes corners, edges, faces of facets (uint32) and JSON of the part and of its bodies and faces into
/// files of `folder`: mesh.f32, edges.f32, faces.u32, part.json, model.json. That is there whatever is wrong
/// with the bodies that are asked for. Errors: kIo; as view_part().
Result<void> write_part_view(const PartAsked& asked, const std::string& folder);

}  // namespace tiltfeed::desk
