#include "cad/shape/tessellate.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <IMeshTools_Parameters.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <algorithm>
#include <array>
#include <cmath>

#include "cad/shape/last_words.h"
#include "cad/shape/surface_gap.h"
#include "kinematics/basics/decimal.h"
#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::cad {
namespace {

using pathgen::FaceFacets;
using pathgen::PartFace;

constexpr double kAngle =
    0.5;  // rad, between facets: of small roundings, which the distance alone leaves square
constexpr double kWorthMore = 0.9;  // a round that leaves more than this of the deviation does not help
constexpr double kSpare = 0.9;      // of the figure that the last round would have needed
// Barycentric: the middle, of each side, and half way from the middle to each corner.
constexpr std::array<std::array<double, 3>, 7> kInside = {{{1.0 / 3, 1.0 / 3, 1.0 / 3},
                                                           {0.5, 0.5, 0.0},
                                                           {0.0, 0.5, 0.5},
                                                           {0.5, 0.0, 0.5},
                                                           {2.0 / 3, 1.0 / 6, 1.0 / 6},
                                                           {1.0 / 6, 2.0 / 3, 1.0 / 6},
                                                           {1.0 / 6, 1.0 / 6, 2.0 / 3}}};
constexpr std::array<double, 3> kAlongEdge = {0.25, 0.5, 0.75};

Point<Part> point_of(const gp_Pnt& p) { return {p.X(), p.Y(), p.Z()}; }

double to_segment(Point<Part> p, Point<Part> a, Point<Part> b) {
  const Vec3 along = b - a;
  const double square = dot(along, along);
  const double t = square > 0.0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0.0;
  return length(p - (a + along * t));
}

/// The curves of a face's edges against the sides of facets that stand for them.
double edge_deviation(const TopoDS_Face& face, const Handle(Poly_Triangulation) & mesh,
                      const TopLoc_Location& at, const std::vector<Point<Part>>& corners) {
  double most = 0.0;
  for (TopExp_Explorer e(face, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge& edge = TopoDS::Edge(e.Current());
    if (BRep_Tool::Degenerated(edge)) continue;
    const Handle(Poly_PolygonOnTriangulation) sides = BRep_Tool::PolygonOnTriangulation(edge, mesh, at);
    if (sides.IsNull() || !sides->HasParameters()) continue;
    const BRepAdaptor_Curve curve(edge);
    const auto corner = [&](int i) { return corners[static_cast<std::size_t>(sides->Node(i) - 1)]; };
    for (int i = 1; i < sides->NbNodes(); ++i)
      for (const double share : kAlongEdge) {
        const double t = sides->Parameter(i) + share * (sides->Parameter(i + 1) - sides->Parameter(i));
        most = std::max(most, to_segment(point_of(curve.Value(t)), corner(i), corner(i + 1)));
      }
  }
  return most;
}

/// Nothing where OpenCASCADE has made no facets of the face.
/// `at_corners`: the deviation there, which no finer mesh mends.
bool read_face(const TopoDS_Face& face, FaceFacets& out, PartFace& facts, double& at_corners) {
  TopLoc_Location at;
  const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, at);
  if (mesh.IsNull() || mesh->NbTriangles() == 0 || !mesh->HasUVNodes()) return false;
  const SurfaceGap gap(face);
  facts.surface = gap.kind();
  const bool turned = face.Orientation() == TopAbs_REVERSED;
  const auto count = static_cast<std::size_t>(mesh->NbNodes());
  out.corners.resize(count), out.normals.resize(count);
  facts.deviation = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const int node = static_cast<int>(i) + 1;
    out.corners[i] = point_of(mesh->Node(node).Transformed(at.Transformation()));
    const gp_Pnt2d uv = mesh->UVNode(node);
    const Vec3 n = gap.normal(uv.X(), uv.Y());
    out.normals[i] = turned ? -n : n;
    facts.deviation = std::max(facts.deviation, gap(out.corners[i], uv.X(), uv.Y()));
  }
  at_corners = facts.deviation;
  for (int i = 1; i <= mesh->NbTriangles(); ++i) {
    std::array<int, 3> node{};
    mesh->Triangle(i).Get(node[0], node[1], node[2]);
    if (turned) std::swap(node[1], node[2]);
    const auto corner = [&](int k) {
      return static_cast<std::uint32_t>(node[static_cast<std::size_t>(k)] - 1);
    };
    const Point<Part> a = out.corners[corner(0)];
    const Vec3 b = out.corners[corner(1)] - a, c = out.corners[corner(2)] - a;
    // At a pole corners are one place.
    if (dot(b, b) == 0.0 || dot(c, c) == 0.0 || dot(b - c, b - c) == 0.0) continue;
    out.facets.push_back({corner(0), corner(1), corner(2)});
    const gp_Pnt2d ua = mesh->UVNode(node[0]), ub = mesh->UVNode(node[1]), uc = mesh->UVNode(node[2]);
    for (const auto& [s, t, w] : kInside)
      facts.deviation = std::max(facts.deviation, gap(a + b * t + c * w, s * ua.X() + t * ub.X() + w * uc.X(),
                                                      s * ua.Y() + t * ub.Y() + w * uc.Y()));
  }
  facts.deviation = std::max(facts.deviation, edge_deviation(face, mesh, at, out.corners));
  return true;
}

struct BodyFacets {
  std::vector<PartFace> faces;
  std::vector<FaceFacets> facets;
  std::size_t worst = 0;    ///< the face with the largest deviation
  double at_corners = 0.0;  ///< its deviation at corners
};

std::string name_of(const LoadedBody& body, std::size_t face) {
  const std::string& entity = body.faces[face].entity;
  return "body \"" + body.name + "\", " + (entity.empty() ? "face " + std::to_string(face + 1) : entity);
}

Result<BodyFacets> mesh_once(const LoadedBody& body, double asked, const std::string& file) {
  BRepTools::Clean(*body.shape);  // a finer mesh that is there would be kept
  now_at("meshing body \"" + body.name + "\"");
  IMeshTools_Parameters parameters;
  parameters.Deflection = asked, parameters.Angle = kAngle;
  parameters.Relative = false, parameters.ControlSurfaceDeflection = true, parameters.InParallel = false;
  BRepMesh_IncrementalMesh mesh(*body.shape, parameters);
  BodyFacets found;
  std::size_t all = 0, face = 0;
  for (TopExp_Explorer e(*body.shape, TopAbs_FACE); e.More(); e.Next(), ++face) {
    now_at("measuring " + name_of(body, face));
    const FaceFacts& facts = body.faces[face];
    PartFace read;
    read.name = facts.name, read.colour = facts.colour, read.entity = facts.entity;
    FaceFacets facets;
    double at_corners = 0.0;
    if (!read_face(TopoDS::Face(e.Current()), facets, read, at_corners))
      return fail(Code::kMesh, file + ": " + name_of(body, face) +
                                   ": OpenCASCADE makes no facets of it; export the part again");
    all += facets.facets.size();
    if (all > pathgen::kMaxFacets)
      return fail(Code::kLimit, file + ": over the limit of " + std::to_string(pathgen::kMaxFacets) +
                                    " facets at " + name_of(body, face) +
                                    "; use a larger tolerance_mm, or choose bodies");
    found.faces.push_back(std::move(read)), found.facets.push_back(std::move(facets));
    if (found.faces.back().deviation <= found.faces[found.worst].deviation && face > 0) continue;
    found.worst = face, found.at_corners = at_corners;
  }
  return found;
}

bool has_sphere(const LoadedBody& body) {
  for (TopExp_Explorer e(*body.shape, TopAbs_FACE); e.More(); e.Next())
    if (BRepAdaptor_Surface(TopoDS::Face(e.Current()), false).GetType() == GeomAbs_Sphere) return true;
  return false;
}

Result<BodyFacets> mesh_within(const LoadedBody& body, double allowed, const std::string& file) {
  double asked = allowed * (has_sphere(body) ? kAskedShareOfSpheres : kAskedShare), before = 0.0;
  for (int round = 0;; ++round) {
    auto found = mesh_once(body, asked, file);
    if (!found) return found;
    const double reached = found->faces[found->worst].deviation;
    if (reached <= allowed) return found;
    if (round < kMostRounds && found->at_corners <= allowed &&
        (round == 0 || reached < kWorthMore * before)) {
      before = reached;
      asked *= std::clamp(kSpare * allowed / reached, 0.25, 0.7);
      continue;
    }
    const bool edges = found->at_corners > allowed;
    return fail(Code::kMesh,
                file + ": " + name_of(body, found->worst) + " (" + found->faces[found->worst].surface +
                    (edges ? "): its edges lie off its surface by " : "): its facets leave its surface by ") +
                    decimal(edges ? found->at_corners : reached, 5) + " mm, and " + decimal(allowed, 5) +
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
        found->faces[i].body = number;
        facets += found->facets[i].facets.size();
        all.model.deviation = std::max(all.model.deviation, found->faces[i].deviation);
        all.model.faces.push_back(std::move(found->faces[i]));
        all.facets.push_back(std::move(found->facets[i]));
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
