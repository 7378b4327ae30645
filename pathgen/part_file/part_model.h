#pragma once
// What a CAD file holds once it is a mesh: facets, and the faces and bodies that they belong to.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/basics/result.h"
#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::pathgen {

struct PartBody {
  std::string name;     ///< no other body has it
  std::string product;  ///< of the assembly's component, where that has a name of its own
  bool closed = true;   ///< a solid; else a surface
};

struct PartFace {
  std::uint32_t body = 0;               ///< index
  std::string name;                     ///< may be empty
  std::optional<std::uint32_t> colour;  ///< 0xRRGGBB
  std::string surface;                  ///< "cylinder", "spline" ...
  std::string entity;                   ///< of the file: "#123 ADVANCED_FACE"; may be empty
  double deviation = 0.0;               ///< largest distance of its facets from its surface, measured, mm
};

/// Facet i lies on faces[face_of[i]]. A mesh file (STL, OBJ, PLY) has neither faces nor bodies.
struct PartModel {
  Stl mesh;
  std::vector<std::uint32_t> face_of;
  std::vector<PartFace> faces;
  std::vector<PartBody> bodies;
  std::string format;      ///< "STEP", "IGES", "3MF"; empty: a mesh file
  std::string unit;        ///< of the file's numbers, as the file says: "inch"; empty: not said
  double unit_mm = 1.0;    ///< its length, mm
  double allowed = 0.0;    ///< largest deviation that was allowed, mm; 0: the file holds facets, no surfaces
  double deviation = 0.0;  ///< largest of all faces, mm
};

/// Keeps the bodies with these names; a product's name keeps all bodies of it. Empty: keeps all.
/// Errors: kInput with the names that there are, where one is not found, or where `model` has no bodies.
Result<void> keep_bodies(PartModel& model, const std::vector<std::string>& names, const std::string& file);

/// Faces with one of these names or colours ("#rrggbb"), as a flag for each face.
/// Errors: kInput with the names and colours that there are, where one is not found.
Result<std::vector<bool>> faces_named(const PartModel& model, const std::vector<std::string>& names,
                                      const std::string& file);

/// "#rrggbb".
std::string colour_text(std::uint32_t colour);

/// Some lines on what was read: format, unit, bodies, deviation. Empty of a mesh file.
std::vector<std::string> notes_on(const PartModel& model);

}  // namespace tiltfeed::pathgen
