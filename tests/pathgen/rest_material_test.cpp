// Which facets stay uncut, against the tool at every place of a fine tool path.
#include "pathgen/plan/rest_material.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/shapes/cut_passes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

constexpr double kStep = 0.4;

AxisFrame frame_of(AxisMode mode, Sense sense) {
  return {mode, sense, {1, 2, 3}, {1, 0, 0}, {0, 0, 1}, mode == AxisMode::kCircle ? 90.0 : 0.0};
}

PlanOptions uncut_options(const AxisFrame& axis) {
  PlanOptions o = options_with(axis);
  o.pattern.side_step = kStep;
  o.pattern.measure = StepMeasure::kSurface;
  o.find_rest_material = true;
  return o;
}

/// How far the nearest pose of a ball end mill stays from p; poses in bins, so that all are looked at.
class Poses {
 public:
  Poses(const std::vector<CutRun>& runs, double radius) : radius_(radius) {
    for (const CutRun& run : dense(runs, 0.1))
      for (const Pose& pose : run) bins_[bin(pose.tip + pose.axis * radius)].push_back(pose);
  }
  double gap(Point<Part> p) const {
    double least = 1e9;
    const auto [x, y, z] = bin(p);
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) {
          const auto found = bins_.find({x + i, y + j, z + k});
          if (found == bins_.end()) continue;
          for (const Pose& pose : found->second) {
            const Point<Part> centre = pose.tip + pose.axis * radius_;
            least = std::min(least, distance_to_segment(p, centre, centre + pose.axis * 20.0) - radius_);
          }
        }
    return least;
  }

 private:
  static constexpr double kBin = 4.0;  // over the radius
  static std::array<int, 3> bin(Point<Part> p) {
    return {static_cast<int>(std::floor(p.x / kBin)), static_cast<int>(std::floor(p.y / kBin)),
            static_cast<int>(std::floor(p.z / kBin))};
  }
  double radius_;
  std::map<std::array<int, 3>, std::vector<Pose>> bins_;
};

TEST(RestReason, IsWhatNoPoseOfAFinePathTouches) {
  for (const auto& [mode, sense] :
       {std::pair{AxisMode::kFixed, Sense::kOutward}, std::pair{AxisMode::kLine, Sense::kOutward},
        std::pair{AxisMode::kPoint, Sense::kInward}, std::pair{AxisMode::kCircle, Sense::kInward}}) {
    SCOPED_TRACE(static_cast<int>(mode));
    const AxisFrame axis = frame_of(mode, sense);
    const CheckedMesh part = slab(axis);
    const PlanOptions o = uncut_options(axis);
    const auto planned = plan(part, o, nullptr);
    ASSERT_TRUE(planned) << planned.error().message;
    ASSERT_TRUE(planned->report.uncut);
    const RestReport& uncut = *planned->report.uncut;
    const double r = o.cutter.radius(),
                 ridge = r - std::sqrt(r * r - kStep * kStep / 4.0) + 2.0 * o.tolerance;
    const Poses poses(runs_of(planned->path), r);
    std::map<std::uint32_t, double> share;
    for (const RestFacet& f : uncut.facets) {
      share[f.facet] = f.share;
      EXPECT_TRUE(f.why == RestReason::kCutter || f.why == RestReason::kWall);
    }
    const Deformation map(axis, 1.0);
    std::size_t whole = 0, none = 0, wrong = 0;
    for (std::size_t i = 0; i < part.mesh.facets.size(); ++i) {
      const auto& f = part.mesh.facets[i];
      const Point<Part> a = part.mesh.vertices[f[0]], b = part.mesh.vertices[f[1]],
                        c = part.mesh.vertices[f[2]];
      const Point<Part> middle = lerp(lerp(a, b, 0.5), c, 1.0 / 3.0);
      const Vec3 n = normalized(cross(b - a, c - a));
      const Vec3 axis_here = map.axis_at(middle + n * r);
      if (dot(n, axis_here) < 0.5) continue;  // walls are judged below
      const double gap = poses.gap(middle);
      const double reported = share.contains(part.mesh.source[i]) ? share[part.mesh.source[i]] : 0.0;
      if (reported == 1.0) ++whole, wrong += gap > 0.5 * o.tolerance ? 0 : 1;
      if (reported == 0.0) ++none, wrong += gap < ridge ? 0 : 1;
    }
    EXPECT_LE(wrong * 50, whole);  // touched by chance
    EXPECT_GT(whole, 20u);
    EXPECT_GT(none, 200u);
    EXPECT_GT(uncut.area, 1.0);
    EXPECT_LT(uncut.area, uncut.facing_area);
    EXPECT_GT(uncut.away, part.mesh.facets.size() / 4);
  }
}

/// A plate of 20 by 20 whose middle strip, 3 wide, lies 5 lower.
CheckedMesh slotted() {
  return sheet(kUpright, {-10, 10, -10, 10, 40, 4},
               [](double x, double) { return std::abs(x) < 1.6 ? -5.0 : 0.0; });
}

TEST(RestReason, NamesTheReason) {
  const CheckedMesh part = slotted();
  const auto why_of = [&](const PlanOptions& o) {
    const auto planned = plan(part, o, nullptr);
    EXPECT_TRUE(planned) << (planned ? "" : planned.error().message);
    std::map<RestReason, double> area;
    if (!planned || !planned->report.uncut) return area;
    for (const RestFacet& f : planned->report.uncut->facets) {
      const auto& v = part.mesh.facets[f.facet];
      const Vec3 twice = cross(part.mesh.vertices[v[1]] - part.mesh.vertices[v[0]],
                               part.mesh.vertices[v[2]] - part.mesh.vertices[v[0]]);
      if (twice.z > 0.0) area[f.why] += f.share * twice.z / 2.0;  // seen from above
    }
    return area;
  };
  PlanOptions o = uncut_options(kUpright);
  // The floor of the slot, 3 by 20, and its walls, 0.5 by 20 seen from above.
  auto area = why_of(o);
  EXPECT_EQ(area.size(), 1u);
  EXPECT_GE(area[RestReason::kCutter], 60.0);
  EXPECT_LE(area[RestReason::kCutter], 80.0 + 1e-9);
  o.cutter.diameter = 1.0;  // fits but for the fillets, 0.45 by 20 of floor and walls
  area = why_of(o);
  EXPECT_LT(area[RestReason::kCutter], 25.0);
  o.containment.first = {-20.0, 0.0};
  area = why_of(o);
  EXPECT_NEAR(area[RestReason::kContainment], 200.0, 10.0);
  o.containment = {};
  o.cutter.cutting_length = 2.0, o.cutter.shank_diameter = 6.0;  // does not go down the slot
  area = why_of(o);
  EXPECT_GE(area[RestReason::kShank], 60.0);
  EXPECT_EQ(area.count(RestReason::kHolder), 0u);
  o.cutter.cutting_length = 0.0, o.cutter.shank_diameter = 0.0, o.cutter.shank_length = 3.0;
  o.cutter.holder = {{10.0, 10.0, 20.0}};
  area = why_of(o);
  // The floor, of which the fillets are the cutter's, and of the walls what lies deeper than 3.
  EXPECT_GE(area[RestReason::kHolder], 60.0 - 20.0 * 0.9);
  EXPECT_NEAR(area[RestReason::kHolder] + area[RestReason::kCutter], 60.0 + 2.0 * 20.0 * 0.2, 3.0);
}

TEST(RestReason, TheTiltLimit) {
  const AxisFrame axis = frame_of(AxisMode::kPoint, Sense::kOutward);
  PlanOptions o = uncut_options(axis);
  o.tilt_max = Angle::from_degrees(8.0);
  const auto planned = plan(slab(axis), o, nullptr);
  ASSERT_TRUE(planned && planned->report.uncut);
  EXPECT_TRUE(std::any_of(planned->report.uncut->facets.begin(), planned->report.uncut->facets.end(),
                          [](const RestFacet& f) { return f.why == RestReason::kTilt; }));
}

}  // namespace
}  // namespace tiltfeed
