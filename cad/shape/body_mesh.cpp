#include "cad/shape/body_mesh.h"

#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>

#include "cad/shape/last_words.h"

namespace tiltfeed::cad {
namespace {

/// True: some are to be split.
bool measure(BodyMesh& mesh, const LoadedBody& body, double allowed, EdgeHalves& halves) {
  bool any = false;
  mesh.facets = 0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    now_at("measuring " + name_of(body, i));
    any = mesh.faces[i]->measure(allowed, halves) || any;
    mesh.facets += mesh.faces[i]->facets();
  }
  return any;
}

}  // namespace

BodyMesh split_within(const LoadedBody& body, double allowed, std::size_t most) {
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(*body.shape, TopAbs_EDGE, edges);
  const auto number = [&](const TopoDS_Edge& edge) {
    return static_cast<std::size_t>(edges.FindIndex(edge));
  };
  BodyMesh mesh;
  for (TopExp_Explorer e(*body.shape, TopAbs_FACE); e.More(); e.Next()) {
    now_at("reading facets of " + name_of(body, mesh.faces.size()));
    auto face = FaceMesh::read(TopoDS::Face(e.Current()), number);
    if (!face) {
      mesh.bare = mesh.faces.size();
      return mesh;
    }
    mesh.faces.push_back(std::move(face));
  }
  // No splitting mends that.
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    if (mesh.faces[i]->at_corners() > mesh.faces[mesh.worst]->at_corners()) mesh.worst = i;
  if (mesh.faces.empty() || mesh.faces[mesh.worst]->at_corners() > allowed) return mesh;
  EdgeHalves halves;
  for (int round = 0; measure(mesh, body, allowed, halves); ++round) {
    if (round == kMostSplits || mesh.facets > most) break;
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      now_at("splitting facets of " + name_of(body, i));
      if (!mesh.faces[i]->split(halves)) mesh.folds = i;
    }
    if (mesh.folds) break;
    halves = {};
  }
  double largest = -1.0;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    if (const double off = mesh.faces[i]->deviation(); off > largest) largest = off, mesh.worst = i;
  return mesh;
}

}  // namespace tiltfeed::cad
