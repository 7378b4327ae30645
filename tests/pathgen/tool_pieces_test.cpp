// The cutting part grown by the allowance, against how far its border is from the cutter itself.

#include "pathgen/tool/tool_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tiltfeed {
using namespace pathgen;
namespace {

/// A taper ball of tip radius r, half-angle w and cutting length l, with a shank as wide as its top.
struct Taper {
  double r, w, l;
  double top() const { return r * std::cos(w) + (l - r + r * std::sin(w)) * std::tan(w); }

  /// Of a place at distance d from the axis and height h over the tip, beside the cone or above it.
  double off(double d, double h) const {
    const auto from = [&](double x0, double y0, double x1, double y1) {
      const double x = x1 - x0, y = y1 - y0;
      const double share = std::clamp(((d - x0) * x + (h - y0) * y) / (x * x + y * y), 0.0, 1.0);
      return std::hypot(d - x0 - share * x, h - y0 - share * y);
    };
    return std::min(from(r * std::cos(w), r - r * std::sin(w), top(), l), from(top(), l, top(), l + 20.0));
  }
};

// (cutter.h, property 4)
TEST(ToolPieces, ATaperGrownByTheAllowanceIsNoLargerThanItSays) {
  for (const double degrees : {3.0, 10.0, 25.0})
    for (const double allowance : {0.0, 0.3, 1.5}) {
      PlanOptions o;
      o.cutter.type = CutterType::kTaperBall;
      o.cutter.diameter = 4.0, o.cutter.taper = Angle::from_degrees(degrees);
      o.cutter.cutting_length = 12.0, o.cutter.shank_length = 40.0;
      o.allowance = allowance;
      const Taper taper{2.0, degrees * std::acos(0.0) / 90.0, 12.0};
      const std::vector<ToolPiece> pieces = tool_pieces(o);
      ASSERT_EQ(pieces.size(), 1u) << "the shank is no wider";
      const ToolPiece& piece = pieces.front();
      EXPECT_NEAR(piece.outer, taper.top() + allowance, 1e-12);
      double most = 0.0;
      for (int i = 0; i <= 200; ++i) {  // up the cone, then up the wall
        const double begin = piece.flat + piece.corner * piece.taper_cos,
                     d = std::min(piece.outer, begin + (piece.outer - begin) * i / 150.0);
        const double h = 2.0 + piece.cone_height(d) + std::max(0, i - 150) * 0.1;
        const double off = taper.off(d, h);
        EXPECT_GE(off, allowance - 1e-5)
            << degrees << " degrees, " << allowance << " mm, at " << d << ", " << h;
        most = std::max(most, off - allowance);
      }
      EXPECT_LE(most, left_at_taper_edge(o) + 1e-5);
      EXPECT_GE(most, left_at_taper_edge(o) - 1e-5) << "nowhere as far off as it says";
    }
}

}  // namespace
}  // namespace tiltfeed
