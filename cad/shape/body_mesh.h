#pragma once
// A body's facets, split where they are further from their surfaces than allowed.

#include <memory>
#include <optional>
#include <vector>

#include "cad/shape/face_mesh.h"
#include "cad/shape/loaded_part.h"

namespace tiltfeed::cad {

/// As often each facet may be split in a chain: each halves its sides, and takes three quarters off the
/// distance.
inline constexpr int kMostSplits = 12;

struct BodyMesh {
  std::vector<std::unique_ptr<FaceMesh>> faces;  ///< in the order in which TopExp_Explorer visits them
  std::optional<std::size_t> bare;               ///< the first face without facets; then there are no others
  std::optional<std::size_t> folds;              ///< a face whose facets would fold over each other
  std::size_t worst = 0;                         ///< the face with the largest deviation
  std::size_t facets = 0;
};

/// Of a body that OpenCASCADE has meshed. Properties: 1 faces along an edge have the same corners there, if
/// they had them before. 2 Facets that are within `allowed` (mm), of sides within it, are left as they were.
/// 3 Ends over `most` facets, after kMostSplits, where a facet would fold over its neighbour, and before the
/// first split where a corner is further off than `allowed`.
BodyMesh split_within(const LoadedBody& body, double allowed, std::size_t most);

}  // namespace tiltfeed::cad
