#pragma once
// What the tests of creases share: tools, fields, axis modes over a place, and the creases of a field.

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "pathgen/creases/creases.h"
#include "pathgen/tool/tool_pieces.h"
#include "tests/shapes/contour_shapes.h"

namespace tiltfeed {
using namespace pathgen;

inline PlanOptions crease_tool(CutterType type, double diameter, double corner = 0.0) {
  PlanOptions options = ball(diameter);
  options.cutter.type = type, options.cutter.corner_radius = corner;
  if (type == CutterType::kTaperBall) options.cutter.taper = Angle::from_degrees(5.0);
  return options;
}

/// What was found over all of the field, or over `bounds`.
inline std::vector<Crease> creases_over(const ClField& field, double diameter, double angle_deg = 10.0,
                                        std::optional<FlatBounds> bounds = {}) {
  CreaseOptions options;
  options.envelope = {0.002, 0.03};
  options.kinks = {Angle::from_degrees(angle_deg), 0.01};
  options.spacing = diameter / 4.0, options.chord = 0.001;
  const auto graph = trace_crease_graph(field, bounds.value_or(field.bounds), options, {});
  EXPECT_TRUE(graph) << graph.error().message;
  return joined_creases(*graph, 0.01, diameter / 4.0);
}

inline std::unique_ptr<const ClField> field_of_tool(const Mesh& mesh, const AxisFrame& frame,
                                                    const PlanOptions& options, double scale = 1.0) {
  ClSurface surface(mesh, Sides::kOutward, {tool_pieces(options).front()});
  const Deformation map(frame, scale);
  FlatIndex index(make_flat_hulls(surface, map, 0.5), map);
  const FlatBounds bounds = index.bounds();
  return std::make_unique<const ClField>(ClField{std::move(surface), map, std::move(index), bounds});
}

struct ModeCase {
  const char* name;
  AxisFrame frame;
};
inline std::vector<ModeCase> mode_cases() {
  AxisFrame fixed, out, in, line, circle, circle_in;
  out.mode = in.mode = AxisMode::kPoint, line.mode = AxisMode::kLine;
  circle.mode = circle_in.mode = AxisMode::kCircle;
  out.origin = {0, 0, -35}, line.origin = {0, 0, -35};
  in.origin = {0, 0, 40}, in.sense = Sense::kInward, in.n = {0, 0, -1};
  circle.origin = {0, 0, -60}, circle.circle_radius = 30.0;
  circle_in.origin = {0, 0, -30}, circle_in.circle_radius = 70.0, circle_in.sense = Sense::kInward;
  circle_in.n = {0, 0, 1};
  return {{"fixed", fixed}, {"point outward", out}, {"point inward", in},
          {"line", line},   {"circle", circle},     {"circle inward", circle_in}};
}

}  // namespace tiltfeed
