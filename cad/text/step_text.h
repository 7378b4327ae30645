#pragma once
// The text of a STEP file (ISO 10303-21) before OpenCASCADE sees it: what is cut short, named and not there,
// or out of range is found here, with the entity's name. OpenCASCADE 7.6 ends in a fault on some of it.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::cad {

/// The entities of a file by number, ascending, with their types.
struct StepEntities {
  std::vector<std::pair<std::uint64_t, std::string>> types;
  std::string schema;  ///< of FILE_SCHEMA: "AUTOMOTIVE_DESIGN"
  /// "#12 ADVANCED_FACE", or "#12" where it is not there.
  std::string name(std::uint64_t number) const;
};

/// Largest coordinate of a CARTESIAN_POINT, in whatever unit.
inline constexpr double kMaxStepCoordinate = 1e9;

/// Errors, kInput, each with line or entity: no ISO-10303-21 or END-ISO-10303-21 (cut short), an entity whose
/// text does not end, two of one number, one that refers to a number that is not there or, by way of others,
/// to itself, a number beyond a double, a coordinate beyond kMaxStepCoordinate, no entities.
Result<StepEntities> check_step_text(std::string_view text, const std::string& file);

}  // namespace tiltfeed::cad
