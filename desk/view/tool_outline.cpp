#include "desk/view/tool_outline.h"

#include <cmath>
#include <numbers>

namespace tiltfeed::desk {
namespace {

using pathgen::Cutter;
using pathgen::CutterType;

constexpr int kSteps = 16;  // of a rounded edge

/// A quarter round and, of a cone, what is left of it: from straight down to where the side begins.
std::vector<std::array<double, 2>> end_of(const Cutter& cutter) {
  const double nose = cutter.nose_radius(), middle = cutter.radius() - nose;
  const double lean = cutter.type == CutterType::kTaperBall ? cutter.taper.radians() : 0.0;
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i <= kSteps; ++i) {
    const double turn = (std::numbers::pi / 2.0 - lean) * i / kSteps;
    points.push_back({middle + nose * std::sin(turn), nose * (1.0 - std::cos(turn))});
    if (nose == 0.0) break;
  }
  return points;
}

}  // namespace

std::vector<ToolOutline> tool_outline(const Cutter& cutter) {
  std::vector<ToolOutline> all{{"cutter", end_of(cutter)}};
  all[0].points.push_back({cutter.cutting_top_radius(), cutter.cutting_end()});
  if (cutter.shank_length > cutter.cutting_end())
    all.push_back(
        {"shank",
         {{cutter.shank_radius(), cutter.cutting_end()}, {cutter.shank_radius(), cutter.shank_length}}});
  double height = cutter.shank_length;
  for (const pathgen::HolderStep& step : cutter.holder) {
    all.push_back(
        {"holder", {{step.lower_diameter / 2.0, height}, {step.upper_diameter / 2.0, height + step.length}}});
    height += step.length;
  }
  return all;
}

}  // namespace tiltfeed::desk
