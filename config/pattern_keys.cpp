#include <algorithm>
#include <string>
#include <vector>

#include "config/description.h"
#include "config/enum_words.h"
#include "config/job_keys.h"

namespace tiltfeed::config {
namespace {

constexpr Range kStep = above(0.0, 1000.0);   // mm
constexpr Range kScallop = above(0.0, 10.0);  // mm
constexpr Range kTurn{-180.0, 180.0};         // degrees
constexpr Range kSlope = between(0.0, 90.0);  // degrees
constexpr Range kCrease{1.0, 90.0};           // degrees

/// A key that not every kind has.
struct KindKey {
  const char* key;
  std::vector<pathgen::PatternKind> kinds;
};

/// A split has the keys of both its halves, raster and z-level.
const std::vector<KindKey>& kind_keys() {
  using enum pathgen::PatternKind;
  static const std::vector<KindKey> keys = {
      {"along", {kRaster, kSplit, kRough}},
      {"angle_deg", {kRaster, kSplit, kRough}},
      {"direction", {kRaster, kSplit, kRough}},
      {"measure", {kRaster, kSplit, kContour, kSpiral, kRough}},
      {"side_step_mm", {kRaster, kSplit, kContour, kSpiral, kRough}},
      {"scallop_mm", {kRaster, kSplit, kContour, kSpiral}},
      {"optimise_scallop_mm", {kRaster}},
      {"step_down_mm", {kZLevel, kSplit, kRough}},
      {"milling", {kZLevel, kSplit, kContour, kSpiral}},
      {"split_slope_deg", {kSplit}},
      {"crease_angle_deg", {kPencil}},
  };
  return keys;
}

bool among(const std::vector<pathgen::PatternKind>& kinds, pathgen::PatternKind kind) {
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

void refuse_unused(const Section& pattern, pathgen::PatternKind kind) {
  for (const KindKey& key : kind_keys()) {
    if (among(key.kinds, kind)) continue;
    std::string users;
    for (const pathgen::PatternKind user : key.kinds)
      users += (users.empty() ? "" : ", ") + std::string(word(kKindWords, user));
    pattern.unused(key.key, "by the kind " + std::string(word(kKindWords, kind)) + ", only by " + users);
  }
}

/// The scallop may not be as high as the cutter's rounding.
void check_scallop(const Section& section, const char* key, const pathgen::Cutter& cutter, double scallop) {
  const double radius = smallest_radius(cutter);
  if (scallop >= radius)
    section.complain(key, exact_text(scallop) + " mm is not below the cutter's smallest radius, " +
                              exact_text(radius) + " mm");
}

/// 0 where it is left out.
double optional_scallop(const Section& section, const char* key, const pathgen::Cutter& cutter) {
  const double scallop = section.optional_number(key, kScallop).value_or(0.0);
  check_scallop(section, key, cutter, scallop);
  return scallop;
}

/// Rows by the ridges of those side_step_mm apart.
void read_ridge(const Section& section, const pathgen::Cutter& cutter, pathgen::Pattern& pattern) {
  if (pattern.kind != pathgen::PatternKind::kRaster)
    section.complain("measure", "ridge is for the kind raster; expected flat, surface or scallop");
  pattern.side_step = section.number("side_step_mm", kStep);
  pattern.scallop = optional_scallop(section, "scallop_mm", cutter);
}

/// How far passes are apart.
void read_step(const Section& section, const pathgen::Cutter& cutter, pathgen::Pattern& pattern) {
  pattern.measure = section.choice<pathgen::StepMeasure>("measure", kMeasureWords, pattern.measure);
  if (pattern.measure == pathgen::StepMeasure::kFlat)
    pattern.optimise_scallop = optional_scallop(section, "optimise_scallop_mm", cutter);
  else
    section.unused("optimise_scallop_mm",
                   "with measure " + std::string(word(kMeasureWords, pattern.measure)) + ", only with flat");
  if (pattern.measure == pathgen::StepMeasure::kRidge) return read_ridge(section, cutter, pattern);
  if (pattern.measure != pathgen::StepMeasure::kScallop) {
    pattern.side_step = section.number("side_step_mm", kStep);
    section.unused("scallop_mm", "with measure " + std::string(word(kMeasureWords, pattern.measure)) +
                                     ", only with scallop and ridge");
    return;
  }
  if (pattern.kind == pathgen::PatternKind::kRough) {
    section.complain("measure", "layers of roughing leave steps, not scallops; expected flat or surface");
    return;
  }
  pattern.scallop = section.number("scallop_mm", kScallop);
  check_scallop(section, "scallop_mm", cutter, pattern.scallop);
  if (const auto most = section.optional_number("side_step_mm", kStep)) pattern.side_step = *most;
}

}  // namespace

bool uses_key(pathgen::PatternKind kind, const std::string& key) {
  for (const KindKey& candidate : kind_keys())
    if (candidate.key == key) return among(candidate.kinds, kind);
  return true;
}

pathgen::Pattern read_pattern(const Section& root, const pathgen::PlanOptions& plan) {
  const Section section = root.section(
      "pattern", {"kind", "along", "angle_deg", "direction", "measure", "side_step_mm", "scallop_mm",
                  "optimise_scallop_mm", "step_down_mm", "milling", "split_slope_deg", "crease_angle_deg"});
  pathgen::Pattern pattern;
  pattern.kind = section.choice<pathgen::PatternKind>("kind", kKindWords, pattern.kind);
  refuse_unused(section, pattern.kind);
  if (plan.axis.mode == pathgen::AxisMode::kFree) {
    if (pattern.kind != pathgen::PatternKind::kRaster)
      section.complain("kind",
                       std::string(word(kKindWords, pattern.kind)) +
                           " needs a predefined axis; in the axis mode free passes are where the planes of "
                           "axis.plane_normals cut the part, so expected raster");
    for (const char* key : {"along", "angle_deg"})
      section.unused(
          key, "in the axis mode free, where passes are where the planes of axis.plane_normals cut the part");
  }
  const bool has_region =
      pattern.kind == pathgen::PatternKind::kContour || pattern.kind == pathgen::PatternKind::kSpiral ||
      pattern.kind == pathgen::PatternKind::kRough || pattern.kind == pathgen::PatternKind::kPencil;
  if (plan.axis.mode == pathgen::AxisMode::kIndexed && has_region)
    section.complain("kind", std::string(word(kKindWords, pattern.kind)) +
                                 " is not made in the axis mode indexed; expected raster, z_level or split");
  const auto uses = [&](const char* key) { return uses_key(pattern.kind, key); };
  pattern.along = section.choice<pathgen::Along>("along", kAlongWords, pattern.along);
  pattern.angle = Angle::from_degrees(section.number("angle_deg", kTurn, pattern.angle.degrees()));
  pattern.direction = section.choice<pathgen::Direction>("direction", kDirectionWords, pattern.direction);
  if (uses("side_step_mm")) read_step(section, plan.cutter, pattern);
  if (uses("step_down_mm")) pattern.step_down = section.number("step_down_mm", kStep);
  pattern.climb = section.choice<bool>("milling", kMillingWords, pattern.climb);
  pattern.split_slope =
      Angle::from_degrees(section.number("split_slope_deg", kSlope, tidy(pattern.split_slope.degrees())));
  pattern.crease_angle =
      Angle::from_degrees(section.number("crease_angle_deg", kCrease, tidy(pattern.crease_angle.degrees())));
  return pattern;
}

}  // namespace tiltfeed::config
