#pragma once
// A drawing as SVG text, and a plot in it: what the pictures have in common. Coordinates have one decimal, so
// that the bytes are the same at every run.

#include <string>
#include <vector>

#include "kinematics/basics/result.h"

namespace tiltfeed::pictures {

/// A place of the drawing (px, y downwards), or of a plot's own coordinates.
struct At {
  double x = 0.0, y = 0.0;
};
using Line = std::vector<At>;

/// A number with so many decimals; "-0" never.
std::string fixed(double value, int decimals);

/// `look` everywhere: the attributes of the element, as `fill="#888"`.
class Svg {
 public:
  /// White, in px, with a title for who cannot see it.
  Svg(int width, int height, const std::string& title);

  void line(At from, At to, const std::string& look);
  void path(const Line& places, const std::string& look, bool closed = false);
  void circle(At centre, double radius, const std::string& look);
  void box(At corner, double width, double height, const std::string& look);
  /// `look` may hold text-anchor and font-size; 12 px else.
  void text(At place, const std::string& words, const std::string& look = {});
  /// The end of a line from `from` to `to`, pointing at `to`.
  void arrow(At from, At to, const std::string& colour);

  Result<void> write(const std::string& file) const;

 private:
  std::string body_;
};

/// The line without the places that a straight way passes within `tolerance`.
Line straightened(const Line& line, double tolerance);

/// A short line in each look, with what it means beside it.
void legend(Svg& svg, At place, const std::string& look, const std::string& words);

/// A rectangle of the drawing with coordinates of its own: `low` is at its lower left, `high` at its upper
/// right.
struct Plot {
  At corner;  ///< upper left, px
  double width = 0.0, height = 0.0;
  At low, high;

  At at(At p) const;
  Line at(const Line& places) const;
  double per_x() const { return width / (high.x - low.x); }  ///< px
  /// Lines and figures at multiples of `step`, and what the axes are.
  void grid(Svg& svg, At step, const std::string& x, const std::string& y, int decimals = 0) const;
};

/// A plot of the same scale in both directions, `per_mm` px a unit.
Plot even_plot(At corner, At low, At high, double per_mm);

}  // namespace tiltfeed::pictures
