#pragma once
// The elements of a 3MF model, as they stand in its XML; used by three_mf.cpp only.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::pathgen {

/// x' = x m[0] + y m[3] + z m[6] + m[9], and so on.
using Transform = std::array<double, 12>;
inline constexpr Transform kIdentity = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};

struct MfMaterial {
  std::string name;
  std::optional<std::uint32_t> colour;
};

struct MfComponent {
  std::uint32_t object = 0;  ///< its id
  Transform transform = kIdentity;
};

struct MfObject {
  std::string name, type = "model";
  std::vector<Point<Part>> corners;  ///< in the file's unit
  std::vector<std::array<std::uint32_t, 3>> facets;
  std::vector<std::uint32_t> material;  ///< of each facet, an index of MfModel::materials plus 1; 0: none
  std::vector<MfComponent> components;
};

struct MfModel {
  std::string unit = "millimeter";
  double unit_mm = 1.0;
  std::vector<MfMaterial> materials;
  std::map<std::uint32_t, MfObject> objects;  ///< by id
  std::vector<MfComponent> items;             ///< of the build
  std::vector<std::string> warnings;
};

/// Properties: a component names an object that stands before it, so there is no circle. Errors: as
/// parse_three_mf().
Result<MfModel> read_mf_model(std::string_view xml, const std::string& file);

}  // namespace tiltfeed::pathgen
