#include "cad/shape/tessellate.h"

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <IMeshTools_Parameters.hxx>
#include <Standard_Failure.hxx>
#include <TopoDS_Shape.hxx>
#include <algorithm>

#include "cad/shape/body_mesh.h"
#include "cad/shape/last_words.h"
#include "kinematics/basics/decimal.h"
#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::cad {
namespace {

constexpr double kAngle =
    0.5;  // rad, between facets: of small roundings, which the distance alone leaves square

void mesh_once(const LoadedBody& body, double asked) {
  BRepTools::Clean(*body.shape);  // a finer mesh that is there would be kept
  now_at("meshing body \"" + body.name + "\"");
  IMeshTools_Parameters parameters;
  parameters.Deflection = asked, parameters.Angle = kAngle;
  parameters.Relative = false, parameters.ControlSurfaceDeflection = true, parameters.InParallel = false;
  BRepMesh_IncrementalMesh mesh(*body.shape, parameters);
}

Result<BodyMesh> mesh_within(const LoadedBody& body, double allowed, const std::string& file) {
  double asked = allowed * kAskedShare;
  for (int round = 0;; ++round, asked /= kFiner) {
    mesh_once(body, asked);
    BodyMesh mesh = split_within(body, allowed, pathgen::kMaxFacets);
    const bool last = round == kMostRounds;
    if (mesh.bare) {
      if (!last) continue;
      return fail(Code::kMesh, file + ": " + name_of(body, *mesh.bare) +
                                   ": OpenCASCADE makes no facets of it; export the part again");
    }
    const FaceMesh& worst = *mesh.faces[mesh.worst];
    if (mesh.facets > pathgen::kMaxFacets)
      return fail(Code::kLimit, file + ": over the limit of " + std::to_string(pathgen::kMaxFacets) +
                                    " facets at " + name_of(body, mesh.worst) +
                                    "; use a larger tolerance_mm, or choose bodies");
    if (!mesh.folds && worst.deviation() <= allowed) return mesh;
    const bool edges = worst.at_corners() > allowed;
    if (!edges && !last) continue;
    return fail(Code::kMesh,
                file + ": " + name_of(body, mesh.worst) + " (" + worst.surface() +
                    (edges ? "): its edges lie off its surface by " : "): its facets leave its surface by ") +
                    decimal(edges ? worst.at_corners() : worst.deviation(), 5) + " mm, and " +
                    decimal(allowed, 5) +
                    " mm are allowed; export the part more accurately, or use a larger tolerance_mm");
  }
}

}  // namespace

Result<Tessellated> tessellate(const LoadedPart& part, double allowed, const std::string& file) {
  Tessellated all;
  all.model.format = part.format, all.model.unit = part.unit, all.model.unit_mm = part.unit_mm;
  all.model.allowed = allowed, all.model.mesh.warnings = part.warnings;
  std::size_t facets = 0;
  for (const LoadedBody& body : part.bodies) {
    try {
      auto found = mesh_within(body, allowed, file);
      if (!found) return tl::unexpected(found.error());
      const auto number = static_cast<std::uint32_t>(all.model.bodies.size());
      all.model.bodies.push_back({body.name, body.product, body.closed});
      for (std::size_t i = 0; i < found->faces.size(); ++i) {
        const FaceMesh& face = *found->faces[i];
        const FaceFacts& facts = body.faces[i];
        pathgen::PartFace told;
        told.name = facts.name, told.colour = facts.colour, told.entity = facts.entity;
        told.body = number, told.surface = face.surface(), told.deviation = face.deviation();
        all.model.deviation = std::max(all.model.deviation, told.deviation);
        all.model.faces.push_back(std::move(told));
        all.facets.push_back(face.oriented());
        facets += all.facets.back().facets.size();
      }
    } catch (const Standard_Failure& failure) {
      return fail(Code::kMesh,
                  file + ": OpenCASCADE fails while " + at_now() + ": " + failure.GetMessageString());
    }
    if (facets > pathgen::kMaxFacets)
      return fail(Code::kLimit, file + ": over the limit of " + std::to_string(pathgen::kMaxFacets) +
                                    " facets; use a larger tolerance_mm, or choose bodies");
  }
  return all;
}

}  // namespace tiltfeed::cad
