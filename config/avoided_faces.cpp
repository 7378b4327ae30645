#include "config/avoided_faces.h"

#include <algorithm>
#include <map>

#include "pathgen/options/fixtures.h"

namespace tiltfeed::config {

Result<void> add_avoided_faces(Job& job, const pathgen::PartModel& model, const pathgen::CheckedMesh& part) {
  if (job.avoid_faces.empty()) return {};
  pathgen::Fixtures all;
  if (job.plan.fixtures) all = *job.plan.fixtures;
  for (const std::string& name : job.avoid_faces) {
    const auto chosen = pathgen::faces_named(model, {name}, job.stl_path);
    if (!chosen) return tl::unexpected(chosen.error());
    pathgen::Mesh own;
    std::map<std::uint32_t, std::uint32_t> now;  // of the part's vertices
    for (std::size_t i = 0; i < part.mesh.facets.size(); ++i) {
      if (!(*chosen)[model.face_of[part.mesh.source[i]]]) continue;
      std::array<std::uint32_t, 3> facet{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t vertex = part.mesh.facets[i][k];
        const auto [at, fresh] = now.try_emplace(vertex, static_cast<std::uint32_t>(own.vertices.size()));
        if (fresh) own.vertices.push_back(part.mesh.vertices[vertex]);
        facet[k] = at->second;
      }
      own.facets.push_back(facet);
      own.source.push_back(static_cast<std::uint32_t>(all.names.size()));
    }
    if (own.facets.empty()) continue;
    all.mesh = pathgen::joined(all.mesh, own);
    all.names.push_back("\"" + name + "\" (part.avoid_faces)");
  }
  job.plan.fixtures = std::make_shared<const pathgen::Fixtures>(std::move(all));
  pathgen::FixtureRoom& room = job.plan.fixture_room;
  if (job.fixtures.empty()) room = {};
  for (double* of : {&room.cutter, &room.shank, &room.holder}) *of = std::max(*of, job.avoid);
  return {};
}

}  // namespace tiltfeed::config
