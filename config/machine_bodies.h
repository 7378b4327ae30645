#pragma once
// What machine and set-up look like: solids by link, for the check of collisions. Which link a body belongs
// to and where its coordinates start: config/machines/generic-ac.yaml.

#include <array>
#include <string>
#include <vector>

#include "kinematics/basics/geometry.h"

namespace tiltfeed::config {

enum class SolidKind { kBox, kCylinder, kCone, kStl };

/// Stands on `at`, the middle of its base, and rises along +z; an STL is as its file says. First turned, then
/// moved.
struct SolidShape {
  SolidKind kind = SolidKind::kBox;
  Vec3 size;                                    ///< of a box, mm
  double diameter = 0.0, upper_diameter = 0.0;  ///< of a cylinder or cone, mm
  double height = 0.0;                          ///< mm
  std::string stl;                              ///< the file, resolved
  double stl_unit_mm = 1.0;
  Vec3 at;
  Rotation rotation;
};

enum class BodyLink { kBed, kXSlide, kYSlide, kZSlide, kTable, kCradle, kFork, kHead, kNose };

struct MachineBody {
  std::string name;
  BodyLink link = BodyLink::kBed;
  std::string colour;  ///< "#rrggbb"
  SolidShape shape;
};

/// In the job: fixed to the table, or to the part in whose coordinates it is.
struct Fixture {
  std::string name;
  bool on_part = false;
  std::string colour;
  SolidShape shape;
};

/// How near bodies may come, mm: of a pair the larger of its two. Part and fixtures have none of their own.
struct Clearances {
  double cutter = 0.5, shank = 0.5, holder = 1.0;
  double head = 3.0;          ///< nose, head, fork, and slides that carry the tool
  double table = 5.0;         ///< bed, table, cradle, and slides that carry the work
  double rapid_factor = 2.0;  ///< on rapids all are so much larger
};

struct MachineBodies {
  std::vector<MachineBody> bodies;
  Clearances clearances;
  /// 0: x, 1: y, 2: z; in order from the bed outward. Each axis is in one of both.
  std::vector<int> work_slides, tool_slides{0, 1, 2};
};

inline constexpr const char* kNoColour = "#9aa0a6";

}  // namespace tiltfeed::config
