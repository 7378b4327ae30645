#include "config/part_faces.h"

#include <algorithm>
#include <map>

#include "pathgen/options/fixtures.h"

namespace tiltfeed::config {

namespace {

/// The part's facets on the faces that are flagged, as flags by facet.
std::vector<bool> facets_on(const std::vector<bool>& faces, const pathgen::PartModel& model,
                            const pathgen::Mesh& part) {
  std::vector<bool> on(part.facets.size());
  for (std::size_t i = 0; i < on.size(); ++i) on[i] = faces[model.face_of[part.source[i]]];
  return on;
}

/// A mesh of the facets that are flagged, with the sources that they have.
pathgen::Mesh mesh_of(const pathgen::Mesh& part, const std::vector<bool>& facets) {
  pathgen::Mesh own;
  std::map<std::uint32_t, std::uint32_t> now;  // of the part's vertices
  for (std::size_t i = 0; i < part.facets.size(); ++i) {
    if (!facets[i]) continue;
    std::array<std::uint32_t, 3> facet{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = part.facets[i][k];
      const auto [at, fresh] = now.try_emplace(vertex, static_cast<std::uint32_t>(own.vertices.size()));
      if (fresh) own.vertices.push_back(part.vertices[vertex]);
      facet[k] = at->second;
    }
    own.facets.push_back(facet);
    own.source.push_back(part.source[i]);
  }
  return own;
}

}  // namespace

Result<void> add_avoided_faces(Job& job, const pathgen::PartModel& model, const pathgen::CheckedMesh& part) {
  if (job.avoid_faces.empty()) return {};
  pathgen::Fixtures all;
  if (job.plan.fixtures) all = *job.plan.fixtures;
  for (const std::string& name : job.avoid_faces) {
    const auto chosen = pathgen::faces_named(model, {name}, job.stl_path);
    if (!chosen) return tl::unexpected(chosen.error());
    pathgen::Mesh own = mesh_of(part.mesh, facets_on(*chosen, model, part.mesh));
    if (own.facets.empty())
      return fail(Code::kMesh,
                  job.stl_path + ": \"" + name +
                      "\" of part.avoid_faces is so small that repairing the mesh leaves nothing "
                      "of it; use a smaller tolerance_mm, or leave it out");
    std::fill(own.source.begin(), own.source.end(), static_cast<std::uint32_t>(all.names.size()));
    all.mesh = pathgen::joined(all.mesh, own);
    all.names.push_back("\"" + name + "\" (part.avoid_faces)");
  }
  job.plan.fixtures = std::make_shared<const pathgen::Fixtures>(std::move(all));
  pathgen::FixtureRoom& room = job.plan.fixture_room;
  if (job.fixtures.empty()) room = {};
  for (double* of : {&room.cutter, &room.shank, &room.holder}) *of = std::max(*of, job.avoid);
  return {};
}

Result<void> add_chosen_faces(Job& job, const pathgen::PartModel& model, const pathgen::CheckedMesh& part) {
  job.plan.only_faces = nullptr;
  if (job.only_faces.empty()) return {};
  const auto chosen = pathgen::faces_named(model, job.only_faces, job.stl_path);
  if (!chosen) return tl::unexpected(chosen.error());
  pathgen::ChosenFaces only{{}, facets_on(*chosen, model, part.mesh), job.beyond_faces};
  only.mesh = mesh_of(part.mesh, only.chosen);
  if (only.mesh.facets.empty())
    return fail(Code::kMesh,
                job.stl_path +
                    ": the faces of containment.faces are so small that repairing the mesh leaves "
                    "nothing of them; use a smaller tolerance_mm, or other faces");
  job.plan.only_faces = std::make_shared<const pathgen::ChosenFaces>(std::move(only));
  return {};
}

}  // namespace tiltfeed::config
