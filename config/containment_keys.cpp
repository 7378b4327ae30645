#include <algorithm>
#include <string>

#include "config/description.h"
#include "config/enum_words.h"
#include "config/job.h"
#include "config/job_keys.h"
#include "config/key_ranges.h"
#include "config/polygon.h"
#include "pathgen/options/side_step.h"

namespace tiltfeed::config {
namespace {

constexpr Range kDistance{0.0, 10'000.0};  // mm
constexpr Range kRound{-180.0, 180.0};     // degrees, up to the seam opposite n
constexpr Range kUpright{-90.0, 90.0};     // degrees, pole to pole
constexpr std::size_t kMaxCorners = 1000;  // each edge is held against each
constexpr std::size_t kMostFaces = 100;
constexpr Range kBeyondFaces{0.0, 100.0};  // mm

bool is_angle(const std::string& key) { return key.ends_with("_deg"); }

Range range_of(const std::string& key, pathgen::AxisMode mode) {
  if (key == "rho_mm") return kDistance;
  if (!is_angle(key)) return kPartPlace;
  return key == "phi_deg" && mode == pathgen::AxisMode::kPoint ? kUpright : kRound;
}

/// A typed coordinate in the planner's unit; half turns and quarter turns to the last digit.
double coordinate(const std::string& key, double typed) {
  return is_angle(key) ? typed / 180.0 * kPi : typed;
}

pathgen::Interval read_interval(const Section& section, const char* key, pathgen::AxisMode mode) {
  const auto pair = section.interval(key, range_of(key, mode));
  if (!pair) return {};
  return {coordinate(key, (*pair)[0]), coordinate(key, (*pair)[1])};
}

Section containment_of(const Section& root) {
  return root.optional_section("containment", {"theta_deg", "phi_deg", "x_mm", "y_mm", "rho_mm", "z_mm",
                                               "boundary", "faces", "beyond_faces_mm"});
}

}  // namespace

pathgen::Containment read_containment(const Section& root, pathgen::AxisMode mode) {
  const Section section = containment_of(root);
  const CoordinateKeys keys = coordinate_keys(mode);
  const std::string first = keys.first, second = keys.second, height = keys.height;
  for (const char* key : {"theta_deg", "phi_deg", "x_mm", "y_mm", "rho_mm", "z_mm"})
    if (key != first && key != second && key != height)
      section.unused(key, "in the mode " + std::string(word(kModeWords, mode)) + ", whose coordinates are " +
                              first + ", " + second + ", " + height);
  pathgen::Containment containment;
  containment.first = read_interval(section, keys.first, mode);
  containment.second = read_interval(section, keys.second, mode);
  containment.height = read_interval(section, keys.height, mode);
  if (mode == pathgen::AxisMode::kFree || mode == pathgen::AxisMode::kIndexed)
    section.unused("boundary",
                   "in the mode " + std::string(word(kModeWords, mode)) + ", whose containment is a box");
  const auto corners =
      section.points("boundary", range_of(first, mode), range_of(second, mode), 3, kMaxCorners);
  if (corners.empty()) return containment;
  if (const auto fault = polygon_fault(corners))
    section.complain_at("boundary", fault->corner, fault->message);
  for (const auto& corner : corners)
    containment.boundary.push_back({coordinate(first, corner[0]), coordinate(second, corner[1])});
  return containment;
}

void read_only_faces(const Section& root, Job& job) {
  const Section section = containment_of(root);
  const pathgen::Pattern& pattern = job.plan.pattern;
  job.only_faces = section.lines("faces", kMostFaces);
  job.beyond_faces =
      section.number("beyond_faces_mm", kBeyondFaces,
                     std::min(std::max(pathgen::asked_step(job.plan), pattern.step_down), kBeyondFaces.max));
  if (job.only_faces.empty()) return section.unused("beyond_faces_mm", "without faces");
  if (pattern.kind == pathgen::PatternKind::kRough)
    section.unused("faces", "in the kind rough, whose layers lie over the faces; use the coordinates");
}

}  // namespace tiltfeed::config
