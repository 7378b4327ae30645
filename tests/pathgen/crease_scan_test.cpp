// Creases of the CL surface against a scan of it that lets a ball down.
#include <gtest/gtest.h>

#include "pathgen/creases/creases.h"
#include "tests/shapes/bent_parts.h"
#include "tests/shapes/crease_shapes.h"

namespace tiltfeed {
using namespace pathgen;
namespace {

/// z' of the centre of a ball of radius 1, which may be below 0: let_down() looks over the line's base.
double height_by_search(const Mesh& mesh, AxisLine line, double least) {
  constexpr double kBelow = 200.0;
  line.base = line.base - line.axis * kBelow;
  const double z = let_down(mesh, line, 1.0, least + kBelow);
  return z == kNoSurface ? z : z - kBelow;
}

/// The ball is let down on places `kStep` apart along a line: where the height bends up sharply, a crease
/// must be near; and where a crease crosses the line, it must bend up.
TEST(CreaseScan, AreThoseThatAScanOfTheSurfaceShows) {
  constexpr double kStep = 0.01, kLength = 9.0;
  std::size_t scanned = 0;
  for (const ModeCase& mode : mode_cases()) {
    AxisFrame frame = mode.frame;
    frame.origin = {};
    if (frame.mode == AxisMode::kCircle) frame.circle_radius = 60.0;
    const CheckedMesh part = slab(frame);
    const auto field = field_of_tool(part.mesh, frame, crease_tool(CutterType::kBall, 2.0), kGroundRadius);
    const double mid = 0.0;
    const FlatBounds bounds{-8.0, 8.0, -7.0, 7.0};
    const auto creases = creases_over(*field, 2.0, 25.0, bounds);
    const double least = frame.mode == AxisMode::kFixed ? -5.0 : field->deformation.s() * kGroundRadius - 5.0;
    for (const FlatLine& line :
         {FlatLine{-6.0, mid + 3.3, 1.0, 0.0, kLength}, FlatLine{1.3, -5.0, 0.0, 1.0, kLength}}) {
      std::vector<double> z;
      for (double run = 0.0; run <= kLength; run += kStep)
        z.push_back(
            height_by_search(part.mesh, field->deformation.axis_line(line.x_at(run), line.y_at(run)), least));
      const auto near = [&](double run) {
        double nearest = 1e9;
        const Place p{line.x_at(run), line.y_at(run)};
        for (const Crease& crease : creases)
          for (std::size_t i = 0; i + 1 < crease.size(); ++i)
            nearest = std::min(
                nearest,
                distance_to_segment(Point<Flat>{p.x, p.y, 0},
                                    Point<Flat>{crease[i].point.flat.x, crease[i].point.flat.y, 0},
                                    Point<Flat>{crease[i + 1].point.flat.x, crease[i + 1].point.flat.y, 0}));
        return nearest;
      };
      for (std::size_t k = 3; k + 3 < z.size(); ++k) {
        if (z[k - 2] == kNoSurface || z[k] == kNoSurface || z[k + 2] == kNoSurface) continue;
        const double before = (z[k - 1] - z[k - 3]) / (2 * kStep),
                     behind = (z[k + 3] - z[k + 1]) / (2 * kStep);
        const double bend = std::atan(behind) - std::atan(before);
        if (std::abs(before) < 3.0 && std::abs(behind) < 3.0 && bend > 40.0 / 180.0 * kPi) {
          EXPECT_LT(near(static_cast<double>(k) * kStep), 4.0 * kStep)
              << mode.name << " run " << static_cast<double>(k) * kStep;
          ++scanned;
        }
      }
      for (const Crease& crease : creases)
        for (std::size_t i = 0; i + 1 < crease.size(); ++i) {
          const Point<Flat> a = crease[i].point.flat, b = crease[i + 1].point.flat;
          const double da = line.dx * (a.y - line.y) - line.dy * (a.x - line.x),
                       db = line.dx * (b.y - line.y) - line.dy * (b.x - line.x);
          if ((da > 0.0) == (db > 0.0)) continue;
          const double f = da / (da - db), x = a.x + f * (b.x - a.x), y = a.y + f * (b.y - a.y);
          const double run = line.run_of(x, y);
          if (run < 0.1 || run > kLength - 0.1) continue;
          // Along the line the bend is that across the crease times the sine between them.
          const double sine =
              std::abs((b.x - a.x) * line.dy - (b.y - a.y) * line.dx) / std::hypot(b.x - a.x, b.y - a.y);
          if (sine < 0.5) continue;
          double most = 0.0;
          const auto at = static_cast<std::size_t>(run / kStep);
          for (std::size_t k = at > 5 ? at - 3 : 2; k <= at + 4 && k + 2 < z.size(); ++k)
            most = std::max(most, (z[k + 2] - 2 * z[k] + z[k - 2]) / (2 * kStep));
          EXPECT_GT(most, 0.15) << mode.name << " run " << run;
          ++scanned;
        }
    }
  }
  EXPECT_GT(scanned, 40u);
}

}  // namespace
}  // namespace tiltfeed
