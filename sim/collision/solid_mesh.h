#pragma once
// Solids as triangle meshes: boxes, bodies of revolution, STL files. The mesh of a round body is inscribed:
// the body is within `sagitta` of it.

#include <array>
#include <cstdint>
#include <vector>

#include "config/machine_bodies.h"
#include "kinematics/basics/result.h"
#include "sim/solid/revolved.h"

namespace tiltfeed::sim {

/// Round bodies have as many sides as keep the mesh within this of them, mm.
inline constexpr double kSagitta = 0.01;

struct SolidMesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> facets;
  double sagitta = 0.0;  ///< mm; 0: the mesh is the body
  bool round = false;    ///< a body of revolution about the line from `centre` along `axis`
  Vec3 centre, axis{0, 0, 1};

  /// Turns it, then moves it.
  void place(const Rotation& rotation, Vec3 shift);
};

/// Stands on the origin, the middle of its base, and rises along +z.
SolidMesh block_mesh(Vec3 size);
/// The outline (r, h) about z from the lower end to the upper; the first and the last point are on the axis
/// or the rims of flat ends.
SolidMesh round_mesh(const std::vector<std::array<double, 2>>& outline);
SolidMesh mesh_of(const Revolved& solid);
/// Where its settings put it. Errors: those of an STL file.
Result<SolidMesh> mesh_of(const config::SolidShape& shape);

}  // namespace tiltfeed::sim
