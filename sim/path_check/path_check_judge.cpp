#include "sim/path_check/path_check_judge.h"

#include <charconv>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// A cutting move that descends past an overhang touches nothing; a path has few of them.
constexpr double kAirShare = 0.01;

std::string number(double value, int decimals) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals).ptr};
}

std::string text_of(const TracePlace& p) {
  if (p.block == 0) return "nowhere";
  return "block " + std::to_string(p.block) + " (line " + std::to_string(p.line) + ", planned move " +
         std::to_string(p.move) + (p.facet == kNoFacet ? "" : ", facet " + std::to_string(p.facet)) +
         (p.tool == ToolPart::kCutter ? "" : std::string(", ") + kToolPartNames[static_cast<int>(p.tool)]) +
         ") at (" + number(p.tip.x, 3) + ", " + number(p.tip.y, 3) + ", " + number(p.tip.z, 3) + ")";
}

}  // namespace

void judge(PathCheckReport& report) {
  const auto limit = [&](const Extreme& e, double most, const char* unit, const std::string& what) {
    if (e.value <= most) return;
    report.failures.push_back(what + " " + (std::isinf(e.value) ? "never" : number(e.value, 4) + unit) +
                              " (limit " + number(most, 4) + unit + "): " +
                              (e.place.block > 0
                                   ? text_of(e.place)
                                   : "planned move " + std::to_string(e.place.move) + " to (" +
                                         number(e.place.tip.x, 3) + ", " + number(e.place.tip.y, 3) + ", " +
                                         number(e.place.tip.z, 3) + ")"));
  };
  const double most = report.tolerance;
  const BlockComparison& p = report.program;
  if (!p.good())
    report.failures.push_back(std::to_string(p.missing) + " blocks missing, " + std::to_string(p.repeated) +
                              " repeated, " + std::to_string(p.altered) + " altered: " + p.first_difference);
  limit(report.tip_deviation, most, " mm", "tip off the planned path by");
  limit(report.axis_deviation, report.axis_tolerance, " degrees", "axis off the planned one by");
  limit(report.missed_point, most, " mm", "planned point missed by");
  limit(report.gouge, most, " mm", "part gouged by");
  limit(report.rapid_overlap, most, " mm", "rapid cuts into the part by");
  if (static_cast<double>(report.air_samples) > kAirShare * static_cast<double>(report.cut_samples))
    limit(report.gap, most, " mm",
          std::to_string(report.air_samples) + " of " + std::to_string(report.cut_samples) +
              " cutting poses in the air, the worst off the part by");
}

}  // namespace tiltfeed::sim
