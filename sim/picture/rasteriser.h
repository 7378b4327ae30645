#pragma once
// A software rasteriser: triangles and thick lines into a colour and depth buffer, given as PNG.
// Screen coordinates: x to the right, y down, pixels; depth grows away from the eye.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed::sim {

/// Linear colour, 0..1 each.
using Colour = Vec3;

/// A corner on the screen.
struct ScreenPoint {
  double x = 0.0, y = 0.0, depth = 0.0;
};

class Rasteriser {
 public:
  /// `background` is the colour of row 0 and of the last row.
  Rasteriser(int width, int height, std::array<Colour, 2> background);

  int width() const { return width_; }
  int height() const { return height_; }
  /// colours(): those of the corners, interpolated over the triangle. Asked for if a pixel of it shows.
  template <class Colours>
  void triangle(const std::array<ScreenPoint, 3>& corners, const Colours& colours);
  /// A triangle of the one colour(), whose pixels are `owner`'s until something else is drawn over them.
  template <class OneColour>
  void triangle(const std::array<ScreenPoint, 3>& corners, std::uint32_t owner, const OneColour& colour);
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
  static std::array<float, 3> floats(Colour c) {
    return {static_cast<float>(c.x), static_cast<float>(c.y), static_cast<float>(c.z)};
  }
  /// A triangle, and the pixels whose middles are in the box round it.
  struct Outline {
    std::array<ScreenPoint, 3> corners;
    double area;    ///< twice, signed
    float nearest;  ///< no pixel of it is nearer
    int x0, x1, y0, y1;
  };
  /// A pixel where a triangle comes nearer than what was there, and the corners' shares in it.
  struct Spot {
    std::size_t pixel;
    double a, b, c;
  };
  Outline outline(const std::array<ScreenPoint, 3>& corners) const;
  /// The spots of a row, whose depth becomes theirs; good until the next call.
  std::span<const Spot> cover(const Outline& outline, int y);
  void mix(int x, int y, double depth, Colour colour, double alpha);

  int width_, height_;
  std::vector<std::array<float, 3>> colour_;
  std::vector<float> depth_;
  std::vector<std::uint32_t> owner_;  ///< none, until a triangle has one
  std::vector<Spot> spots_;           ///< room for a row's
};

template <class Colours>
void Rasteriser::triangle(const std::array<ScreenPoint, 3>& corners, const Colours& colours) {
  std::optional<std::array<Colour, 3>> of;
  const Outline o = outline(corners);
  for (int y = o.y0; y <= o.y1; ++y) {
    for (const auto& [pixel, a, b, c] : cover(o, y)) {
      if (!of) of = colours();
      colour_[pixel] = floats((*of)[0] * a + (*of)[1] * b + (*of)[2] * c);
      if (!owner_.empty()) owner_[pixel] = kNobody;
    }
  }
}

template <class OneColour>
void Rasteriser::triangle(const std::array<ScreenPoint, 3>& corners, std::uint32_t owner,
                          const OneColour& colour) {
  if (owner_.empty()) owner_.assign(colour_.size(), kNobody);
  std::optional<std::array<float, 3>> of;
  const Outline o = outline(corners);
  for (int y = o.y0; y <= o.y1; ++y) {
    for (const Spot& spot : cover(o, y)) {
      if (!of) of = floats(colour());
      colour_[spot.pixel] = *of, owner_[spot.pixel] = owner;
    }
  }
}

}  // namespace tiltfeed::sim
