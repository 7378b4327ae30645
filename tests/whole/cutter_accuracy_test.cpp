// Brute-force proof for every cutter in every axis mode, outside and inside work. The part is a slab bent
// round the axis feature, with sharp steps whose walls run along the tool axis, a ridge, a V-groove, a steep
// rib across and smooth waves. Dense poses along every path are held against it with the whole tool: cutting
// part, shank and holder (sim/tool_solid) must not gouge, the cutter must be in contact, rapids must keep
// clear.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "pathgen/mesh/mesh_check.h"
#include "pathgen/plan/plan.h"
#include "sim/parts/parts.h"
#include "tests/judges/path_proof.h"
#include "tests/shapes/bent_parts.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr std::size_t kLeastPoses = 100'000;

enum class Shape { kSlab, kTube, kTyre };

struct Case {
  std::string name;
  PlanOptions options;
  Shape shape = Shape::kSlab;
};

CheckedMesh part_of(const Case& c) {
  if (c.shape == Shape::kSlab) return slab(c.options.axis);
  if (c.shape == Shape::kTube) return tube(c.options.axis);
  Stl stl;
  stl.facets = sim::tyre_segment();
  return *check_mesh(stl);
}

std::vector<Cutter> cutters() {
  Cutter tool;
  tool.length = 60.0, tool.shank_length = 22.0, tool.cutting_length = 6.0;
  tool.holder = {{12.0, 16.0, 6.0}, {18.0, 18.0, 4.0}};
  Cutter ball = tool, bull = tool, flat = tool, taper = tool;
  ball.type = CutterType::kBall, ball.diameter = 3.0, ball.shank_diameter = 2.4;
  bull.type = CutterType::kBullNose, bull.diameter = 4.0, bull.corner_radius = 0.8;
  flat.type = CutterType::kFlat, flat.diameter = 3.0, flat.shank_diameter = 4.0;
  taper.type = CutterType::kTaperBall, taper.diameter = 2.0, taper.taper = Angle::from_degrees(6.0);
  return {ball, bull, flat, taper};
}

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

struct Field {
  const char* name;
  AxisMode mode;
  Sense sense;
  Along along;
};

/// Oblique to the coordinate axes of the part, off the origin.
PlanOptions options_of(const Field& field, const Cutter& cutter, double tolerance) {
  PlanOptions o;
  o.name = "slab", o.cutter = cutter, o.tolerance = tolerance;
  o.axis = {field.mode, field.sense, {7, -3, 11}, {0.8, 0.6, 0}, {-0.36, 0.48, 0.8}, 0.0};
  if (field.mode == AxisMode::kCircle) o.axis.circle_radius = field.sense == Sense::kOutward ? 25.0 : 90.0;
  o.pattern.along = field.along, o.pattern.side_step = 0.9;
  o.links.clearance = 3.0, o.links.approach = 1.0;
  o.cut_feed = Feed::from_mm_per_min(1000), o.plunge_feed = Feed::from_mm_per_min(300);
  return o;
}

std::vector<Case> cases() {
  using enum AxisMode;
  using enum Sense;
  const char* const tools[] = {"ball", "bull", "flat", "taper"};
  const Field fields[] = {
      {"fixed", kFixed, kOutward, Along::kX},        {"point_outward", kPoint, kOutward, Along::kY},
      {"point_inward", kPoint, kInward, Along::kX},  {"line_outward", kLine, kOutward, Along::kX},
      {"line_inward", kLine, kInward, Along::kY},    {"circle_outward", kCircle, kOutward, Along::kX},
      {"circle_inward", kCircle, kInward, Along::kY}};
  std::vector<Case> all;
  for (const Field& field : fields)
    for (std::size_t i = 0; i < 4; ++i) {
      const std::string name = std::string(field.name) + "_" + tools[i];
      for (const double tolerance : {0.01, 0.002})
        all.push_back(
            {name + (tolerance < 0.005 ? "_fine" : ""), options_of(field, cutters()[i], tolerance)});
    }
  for (std::size_t i = 0; i < 4; ++i) {
    // Stock to leave, and passes askew.
    const Field& field = fields[i + 3];
    Case stock{std::string(field.name) + "_" + tools[i] + "_stock", options_of(field, cutters()[i], 0.01)};
    stock.options.allowance = 0.15, stock.options.radial_stock = 0.1, stock.options.axial_stock = 0.2;
    stock.options.pattern.angle = Angle::from_degrees(30.0);
    all.push_back(stock);
    // Right round a line.
    const Sense sense = i % 2 == 0 ? kInward : kOutward;
    const Field round{sense == kInward ? "bore" : "shaft", kLine, sense, i < 2 ? Along::kX : Along::kY};
    all.push_back(
        {std::string(round.name) + "_" + tools[i], options_of(round, cutters()[i], 0.01), Shape::kTube});
    // So short that shank or holder would hit the part: what they keep the cutter from is left out.
    const Field& other = fields[2 * i % 7];
    Case stub{std::string(other.name) + "_" + tools[i] + "_stub", options_of(other, cutters()[i], 0.01)};
    stub.options.cutter.cutting_length = 2.2, stub.options.cutter.shank_length = 3.5;
    if (i % 2 == 0) stub.options.cutter.shank_diameter = 6.0;
    all.push_back(stub);
  }
  // The tyre mould's grooves, from the inside.
  Case tyre{"tyre_bull", options_of({"", kCircle, kInward, Along::kX}, cutters()[1], 0.01), Shape::kTyre};
  tyre.options.axis = {kCircle, kInward, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 280.0};
  tyre.options.cutter.diameter = 2.0, tyre.options.cutter.corner_radius = 0.4;
  tyre.options.pattern.side_step = 4.0;
  all.push_back(tyre);
  return all;
}

/// Cuts of no length where the cutter stands on the slab, from exact drops, moved by `by` along the axis.
ToolPath standing(const CheckedMesh& part, const AxisFrame& axis, const Cutter& cutter, double by) {
  const sim::PartDistance surface(part.mesh);
  const sim::ToolSolid tool(cutter);
  ToolPath path;
  for (double u = -11.7; u < 12.0; u += 0.83)
    for (double v = -9.6; v < 10.0; v += 1.21) {
      const AxisLine line = Deformation(axis, kGroundRadius).axis_line(u, v);
      const Pose high{line.base + line.axis * 12.0, line.axis};
      const Pose low{high.tip - line.axis * (tool.drop(surface, high).value - by), line.axis};
      path.moves.push_back({high, MoveKind::kRapid});
      path.moves.push_back({low, MoveKind::kPlunge});
      path.moves.push_back({low, MoveKind::kCut});
      path.moves.push_back({high, MoveKind::kRapid});
    }
  return path;
}

TEST(CutterProof, TellsGoodPathsFromBad) {
  const AxisFrame axis{AxisMode::kFixed, Sense::kOutward,    {7, -3, 11},
                       {0.8, 0.6, 0},    {-0.36, 0.48, 0.8}, 0.0};
  const CheckedMesh part = slab(axis);
  constexpr double kTolerance = 0.01, kExact = 1e-6;
  for (const Cutter& cutter : cutters()) {
    const auto measure = [&](const Cutter& judged, double by) {
      const ToolPath path = standing(part, axis, cutter, by);
      return PathProof(axis, Along::kX, judged, kTolerance, part, path).measure(1);
    };
    const Measured good = measure(cutter, 0.0);
    EXPECT_GT(good.poses, 1000u);
    EXPECT_LT(good.gouge, kExact) << pasteable(good.gouge_at);
    EXPECT_LT(good.contact, kExact) << pasteable(good.contact_at);
    EXPECT_LT(good.rapid_overlap, kExact) << pasteable(good.rapid_at);
    // Too low by 0.05 on a level place is as deep, and so is the end of the plunge.
    const Measured low = measure(cutter, -0.05);
    EXPECT_GT(low.gouge_by[0], 0.035);
    EXPECT_LE(low.gouge_by[0], 0.05 + kExact);
    EXPECT_GT(low.rapid_overlap, 0.035);
    EXPECT_NEAR(measure(cutter, 0.05).contact, 0.05, 0.01);
    // A shank or holder that reaches down beside the ridge.
    Cutter stout = cutter;
    stout.cutting_length = 2.5, stout.shank_diameter = 9.0;
    const Measured shank = measure(stout, 0.0);
    EXPECT_GT(shank.gouge_by[1], 0.1);
    EXPECT_LT(shank.gouge_by[0], 2 * sim::ToolSolid::kJointOverlap);
    Cutter stub = cutter;
    stub.cutting_length = 2.0, stub.shank_length = 2.5;
    const Measured holder = measure(stub, 0.0);
    EXPECT_GT(holder.gouge_by[2], 0.1);
    EXPECT_GT(holder.rapid_overlap, 0.1);
  }
}

class CutterAccuracy : public ::testing::TestWithParam<Case> {};

TEST_P(CutterAccuracy, GougesNothingAndStaysInContact) {
  const Case& c = GetParam();
  const PlanOptions& o = c.options;
  const CheckedMesh part = part_of(c);
  const auto start = std::chrono::steady_clock::now();
  const auto planned = plan(part, o, {});
  ASSERT_TRUE(planned) << planned.error().message;
  const auto proving = std::chrono::steady_clock::now();
  const PathProof proof(o.axis, o.pattern.along, o.cutter, o.tolerance, part, planned->path,
                        {o.allowance, o.radial_stock, o.axial_stock});
  const Measured m = proof.measure(kLeastPoses);
  const auto end = std::chrono::steady_clock::now();
  std::printf(
      "%-22s %5zu facets, plan %.2f s, %5zu moves; %6zu poses in %.2f s: cutter %.5f, shank %.5f, holder "
      "%.5f, contact %.5f (drop over in %zu, most %.2f); %zu rapid poses: %.5f\n",
      c.name.c_str(), part.mesh.facets.size(), std::chrono::duration<double>(proving - start).count(),
      planned->path.moves.size(), m.poses, std::chrono::duration<double>(end - proving).count(),
      m.gouge_by[0], m.gouge_by[1], m.gouge_by[2], m.contact, m.plain_over, m.plain_drop, m.rapid_poses,
      m.rapid_overlap);
  for (const std::string& warning : planned->report.warnings) std::printf("    %s\n", warning.c_str());
  EXPECT_GE(m.poses, kLeastPoses);
  EXPECT_LE(m.gouge, o.tolerance) << pasteable(m.gouge_at);
  // Along the normal a right-angled rim may be deeper than it must shrink.
  if (o.cutter.type == CutterType::kFlat) {
    EXPECT_LE(m.gouge_by[0] * std::sqrt(2.0), o.tolerance) << pasteable(m.gouge_at);
  }
  EXPECT_LE(m.contact, o.tolerance) << pasteable(m.contact_at);
  EXPECT_LE(m.rapid_overlap, o.tolerance) << pasteable(m.rapid_at);
  EXPECT_GE(planned->report.passes, 20u);
}

INSTANTIATE_TEST_SUITE_P(Cutters, CutterAccuracy, ::testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace tiltfeed
