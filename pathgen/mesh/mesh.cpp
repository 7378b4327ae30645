#include "pathgen/mesh/mesh.h"

namespace tiltfeed::pathgen {

std::string to_string(DefectKind kind) {
  switch (kind) {
    case DefectKind::kDegenerate:
      return "facets without area";
    case DefectKind::kDuplicate:
      return "duplicate facets";
    case DefectKind::kOpenEdge:
      return "open edges";
    case DefectKind::kNonManifold:
      return "edges with more than two facets";
    case DefectKind::kMisoriented:
      return "edges between facets that face opposite ways";
    case DefectKind::kFlipped:
      return "facets turned over";
    case DefectKind::kInsideOut:
      return "shells inside out";
    case DefectKind::kWelded:
      return "corners moved";
    case DefectKind::kSplit:
      return "facets cut up";
    case DefectKind::kFlap:
      return "flaps left out";
    case DefectKind::kSeparated:
      return "edges of touching solids";
    case DefectKind::kFilled:
      return "holes filled";
  }
  return "unknown defect";
}

}  // namespace tiltfeed::pathgen
