#pragma once
// A software rasteriser: triangles and thick lines into a colour and depth buffer, given as PNG.
// Screen coordinates: x to the right, y down, pixels; depth grows away from the eye.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kinematics/geometry.h"
#include "kinematics/result.h"

namespace tiltfeed::sim {

/// Linear colour, 0..1 each.
using Colour = Vec3;

/// A corner on the screen.
struct ScreenPoint {
  double x = 0.0, y = 0.0, depth = 0.0;
};

class Raster {
 public:
  /// `background` is the colour of row 0 and of the last row.
  Raster(int width, int height, std::array<Colour, 2> background);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Colours are interpolated over the triangle.
  void triangle(const std::array<ScreenPoint, 3>& corners, const std::array<Colour, 3>& colours);
  /// A triangle of one colour, whose pixels are `owner`'s until something else is drawn over them.
  void triangle(const std::array<ScreenPoint, 3>& corners, Colour colour, std::uint32_t owner);
  /// A line of `thickness` pixels, `bias` nearer to the eye than it is; alpha 0..1 mixes it in. Its depth
  /// does not hide what is drawn later.
  void line(ScreenPoint from, ScreenPoint to, double thickness, Colour colour, double alpha, double bias);
  /// A filled disc, drawn like a line.
  void disc(ScreenPoint centre, double diameter, Colour colour, double bias);
  /// Darkens pixels that lie deeper than what is round them within `radius` pixels: corners and grooves.
  /// `range`: differences of depth beyond this do not count.
  void shade_hollows(double radius, double range, double strength);
  /// Averages blocks of `factor` x `factor` pixels to sRGB: the bytes of a PNG file. The colour of a pixel
  /// that has an owner is multiplied by that of the owner. Errors: kIo.
  Result<std::string> png(int factor, const std::vector<Colour>& by_owner = {}, int threads = 1) const;

 private:
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }
  static constexpr std::uint32_t kNobody = 0xFFFFFFFF;
  /// Calls paint(pixel, a, b, c) where the triangle comes nearer, its shares of the corners with it.
  template <class Paint>
  void cover(const std::array<ScreenPoint, 3>& corners, const Paint& paint);
  void mix(int x, int y, double depth, Colour colour, double alpha);

  int width_, height_;
  std::vector<std::array<float, 3>> colour_;
  std::vector<float> depth_;
  std::vector<std::uint32_t> owner_;  ///< none, until a triangle has one
};

}  // namespace tiltfeed::sim
