#pragma once
// A machine with few bodies and a set-up with few fixtures, for tests; and an own way to where their corners
// are.

#include <algorithm>
#include <string>
#include <vector>

#include "config/job.h"
#include "pathgen/mesh/mesh_check.h"
#include "sim/collision/solid_mesh.h"
#include "sim/motion/forward.h"
#include "sim/proof/convex_gap.h"
#include "tests/shapes/box_mesh.h"

namespace tiltfeed::sim {

/// The machine of that file under config/machines without its bodies, and a ball end mill.
inline config::Job bare_job(const std::string& machine) {
  config::Job job = *config::load_job(SOURCE_DIR "/config/jobs/pin.yaml");
  job.machine = *config::load_machine(SOURCE_DIR "/config/machines/" + machine + ".yaml");
  job.machine.solid = {};
  job.setup.part_zero = {3, -4, 50}, job.setup.fixture = {};
  return job;
}

/// A box of 10 mm, far from everything.
inline pathgen::CheckedMesh far_part() {
  pathgen::CheckedMesh part;
  part.mesh = box_mesh({{Vec3{9000, 9000, 9000}, Vec3{9010, 9010, 9010}}});
  return part;
}

inline config::SolidShape box_at(Vec3 size, Vec3 at, Vec3 turned = {}) {
  config::SolidShape shape;
  shape.kind = config::SolidKind::kBox, shape.size = size, shape.at = at;
  shape.rotation = rotation_about({0, 0, 1}, turned.z) * rotation_about({0, 1, 0}, turned.y) *
                   rotation_about({1, 0, 0}, turned.x);
  return shape;
}

using Corners = std::array<Vec3, 3>;

inline double brute_distance(const Corners& a, const Corners& b) {
  const auto difference = [&](Vec3 u) {
    const auto less = [&](Vec3 p, Vec3 q) { return dot(u, p) < dot(u, q); };
    return *std::min_element(a.begin(), a.end(), less) - *std::max_element(b.begin(), b.end(), less);
  };
  return gap_between(difference, {0.36, 0.48, 0.8}, kInfinity, 1e-9).width;
}

inline std::vector<Corners> facets_of(const SolidMesh& mesh) {
  std::vector<Corners> facets;
  for (const auto& [a, b, c] : mesh.facets)
    facets.push_back({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]});
  return facets;
}

inline double brute_distance(const std::vector<Corners>& a, const std::vector<Corners>& b) {
  double least = kInfinity;
  for (const Corners& one : a)
    for (const Corners& other : b) least = std::min(least, brute_distance(one, other));
  return least;
}

/// Where a point fixed to the spindle, `from_gauge` at home, is in part coordinates: the simulated machine's
/// chain with a tool that ends there.
inline Vec3 spindle_point(const config::Job& job, const Joints& words, Vec3 from_gauge) {
  MachineModel model = job.machine.model;
  const Vec3 off = from_gauge + model.spindle * job.setup.tool_length;  // from the tip
  model.pivot_to_gauge = model.pivot_to_gauge + off;
  const Joints moved{words.x + off.x, words.y + off.y, words.z + off.z, words.a, words.c};
  return from_origin(forward_by_frames(model, job.setup, moved).tip);
}

}  // namespace tiltfeed::sim
