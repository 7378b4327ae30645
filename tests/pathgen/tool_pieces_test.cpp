// The cutting part grown by the allowance, against how far its border is from the cutter itself.

#include "pathgen/tool/tool_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

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

/// How wide a piece with all that is straight above it is at a height over the CL reference, by halving: the
/// largest distance from the axis at which its lower side is no higher.
double width_at(const ToolPiece& piece, double height) {
  const auto lower_side = [&](double d) {
    const double ball_to = piece.flat + piece.corner * piece.taper_cos;
    if (d <= piece.flat) return piece.above_reference - piece.corner;
    if (d <= ball_to || !piece.has_cone())
      return piece.above_reference -
             std::sqrt(std::max(0.0, piece.corner * piece.corner - (d - piece.flat) * (d - piece.flat)));
    return piece.above_reference + piece.cone_height(d);
  };
  if (lower_side(0.0) > height) return 0.0;
  double in = 0.0, out = piece.outer;
  if (lower_side(out) <= height) return out;
  for (int i = 0; i < 60; ++i) (lower_side((in + out) / 2.0) <= height ? in : out) = (in + out) / 2.0;
  return in;
}

double width_at(const std::vector<ToolPiece>& pieces, double height) {
  double widest = 0.0;
  for (const ToolPiece& piece : pieces) widest = std::max(widest, width_at(piece, height));
  return widest;
}

// (T2)
TEST(ToolPieces, WhatLiesInAShadowSticksOutNowhere) {
  std::mt19937 random(5);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution(a, b)(random); };
  int hidden = 0, narrow = 0;
  for (int tool = 0; tool < 600; ++tool) {
    PlanOptions o;
    o.cutter.type = tool % 2 == 0 ? CutterType::kTaperBall : CutterType::kBall;
    o.cutter.diameter = between(1.0, 6.0), o.cutter.taper = Angle::from_degrees(between(1.0, 20.0));
    o.cutter.cutting_length = o.cutter.diameter * between(1.2, 4.0);
    o.cutter.shank_length = o.cutter.cutting_length + 10.0;
    o.cutter.shank_diameter = between(0.5, 8.0);
    o.cutter.holder = {{between(1.0, 12.0), between(12.0, 20.0), 6.0}};
    o.shank.clearance = between(0.0, 1.0) * (tool % 3), o.holder.clearance = between(0.0, 3.0);
    const std::vector<ToolPiece> all = all_pieces(o), kept = tool_pieces(o);
    ASSERT_EQ(kept.front().part, ToolPart::kCutter);
    hidden += all.size() > kept.size();
    for (double h = -o.cutter.diameter; h < o.cutter.shank_length + 8.0; h += 0.031)
      ASSERT_NEAR(width_at(kept, h), width_at(all, h), 1e-7) << "tool " << tool << " at " << h;
    for (std::size_t i = 1; i < kept.size(); ++i) {
      const std::vector<ToolPiece> below(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(i));
      narrow += kept[i].outer <= below.front().outer;
      bool out = false;
      for (double h = kept[i].above_reference; h < o.cutter.shank_length + 20.0 && !out; h += 0.001)
        out = std::any_of(below.begin(), below.end(),
                          [&](const ToolPiece& b) { return width_at(kept[i], h) > width_at(b, h); });
      EXPECT_TRUE(out) << "tool " << tool << ": piece " << i << " could be left out";
    }
  }
  EXPECT_GT(hidden, 100);
  EXPECT_GT(narrow, 5) << "none that only reaches down out of a cone";
}

}  // namespace
}  // namespace tiltfeed
