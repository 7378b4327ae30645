#pragma once
// The facets of one face in its surface's parameters: as OpenCASCADE made them, and split further.

#include <compare>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "kinematics/basics/geometry.h"
#include "pathgen/part_file/cad_stream.h"

class TopoDS_Edge;
class TopoDS_Face;

namespace tiltfeed::cad {

/// A part of an edge between two of its corners. OpenCASCADE's pieces are [0, 1], [1, 2] ...; halves of them
/// [0, 0.5] ...
struct EdgePiece {
  std::size_t edge = 0;
  double from = 0.0, to = 0.0;
  auto operator<=>(const EdgePiece&) const = default;
};

/// What the faces along an edge have in common, so that they stay joined.
struct EdgeHalves {
  std::set<EdgePiece> wanted;                ///< pieces to halve
  std::map<EdgePiece, Point<Part>> middles;  ///< of those that a face has halved
};

class FaceMesh {
 public:
  /// `number` of an edge is the same in each face. Null: OpenCASCADE has made no facets of the face.
  static std::unique_ptr<FaceMesh> read(const TopoDS_Face& face,
                                        const std::function<std::size_t(const TopoDS_Edge&)>& number);
  ~FaceMesh();
  FaceMesh(const FaceMesh&) = delete;
  FaceMesh& operator=(const FaceMesh&) = delete;

  /// Distances, mm, of new facets from the surface, and of their sides on edges from these. Where one is over
  /// `allowed`, notes which sides split() is to halve, pieces of edges in `halves.wanted`. True: noted some.
  bool measure(double allowed, EdgeHalves& halves);
  /// Halves the sides noted, and those on pieces that other faces want. False: a facet would fold over its
  /// neighbour, since an edge's curve is further from its chord than another corner.
  bool split(EdgeHalves& halves);

  std::size_t facets() const;
  /// Of facets and sides on edges when last measured, mm; at_corners() is what no splitting mends.
  double deviation() const;
  double at_corners() const;
  std::string surface() const;
  /// Outward, without those of no area, with normals at the corners.
  pathgen::FaceFacets oriented() const;

 private:
  struct State;
  explicit FaceMesh(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tiltfeed::cad
