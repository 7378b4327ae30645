#include "sim/report/deviation_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tiltfeed::sim {
namespace {

constexpr int kWidth = 1400, kHeight = 875, kOversample = 2;
constexpr Colour kTop{0.93, 0.94, 0.96}, kBottom{0.70, 0.73, 0.77};
constexpr Colour kMark{0.75, 0.0, 0.55}, kMarkHeart{1.0, 1.0, 1.0};
constexpr std::size_t kMarks = 12;
constexpr double kHollowRange = 0.03, kHollowRadius = 12.0, kHollowStrength = 0.6, kBias = 0.02;

Colour colour_of(double left, const std::vector<ColourStop>& scale) {
  if (left <= scale.front().left) return scale.front().colour;
  for (std::size_t i = 1; i < scale.size(); ++i) {
    if (left > scale[i].left) continue;
    const double f = (left - scale[i - 1].left) / (scale[i].left - scale[i - 1].left);
    return scale[i - 1].colour + (scale[i].colour - scale[i - 1].colour) * f;
  }
  return scale.back().colour;
}

/// `key`: where most light comes from, unit.
double light(Vec3 normal, Vec3 view, Vec3 key) {
  if (dot(normal, view) < 0.0) normal = -normal;
  return 0.50 + 0.55 * std::max(0.0, dot(normal, key)) + 0.15 * dot(normal, view);
}

double to_srgb(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
}

}  // namespace

std::vector<ColourStop> colour_scale(const Removal& removal, const RemovalVerdict& verdict) {
  const double tolerance = verdict.tolerance, wanted = verdict.excess_limit;
  const double reach = std::max(removal.reach, 2.0 * wanted);
  // Equal steps of colour for unequal steps of length: what matters lies near the tolerance.
  return {{-4.0 * tolerance, {0.35, 0.0, 0.02}},
          {-tolerance, {0.85, 0.03, 0.03}},
          {-0.5 * tolerance, {0.95, 0.45, 0.10}},
          {0.0, {0.12, 0.60, 0.22}},
          {wanted, {0.45, 0.78, 0.30}},
          {wanted + 0.1 * (reach - wanted), {0.95, 0.85, 0.25}},
          {wanted + 0.4 * (reach - wanted), {0.10, 0.50, 0.85}},
          {reach, {0.05, 0.08, 0.45}}};
}

std::string html_colour(Colour c) {
  std::array<char, 8> text;
  const auto byte = [](double v) { return static_cast<unsigned>(std::lround(to_srgb(v) * 255.0)); };
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", byte(c.x) & 0xFF, byte(c.y) & 0xFF,
                byte(c.z) & 0xFF);
  return text.data();
}

DeviationPicture::DeviationPicture(const pathgen::Mesh& part, const ToolPath& path, const Patches& patches)
    : camera_(part, path, kWidth * kOversample, kHeight * kOversample),
      raster_(kWidth * kOversample, kHeight * kOversample, {kTop, kBottom}) {
  const Vec3 key = normalized(camera_.eye() * 0.55 + camera_.up() * 0.75 - camera_.right() * 0.65);
  std::vector<ScreenPoint> screen;
  screen.reserve(patches.mesh.vertices.size());
  for (const Point<Part> p : patches.mesh.vertices) screen.push_back(camera_.project(p));
  for (std::size_t p = 0; p < patches.mesh.facets.size(); ++p) {
    const auto& [a, b, c] = patches.mesh.facets[p];
    raster_.triangle({screen[a], screen[b], screen[c]}, static_cast<std::uint32_t>(p), [&] {
      const double lit = light(patches.normal[p], camera_.view_from(patches.middle[p]), key);
      return Colour{lit, lit, lit};
    });
  }
  raster_.shade_hollows(kHollowRadius * kOversample, kHollowRange * camera_.scene_radius(), kHollowStrength);
}

Result<std::string> DeviationPicture::png(const Removal& removal, const std::vector<ColourStop>& scale,
                                          int threads) {
  std::vector<Colour> colours(removal.patch_mean.size());
  for (std::size_t p = 0; p < colours.size(); ++p) {
    const double mean = static_cast<double>(removal.patch_mean[p]),
                 low = static_cast<double>(removal.patch_low[p]);
    // A gouge shows even where the mean hides it.
    colours[p] = std::isnan(mean) ? kUnreachedColour : colour_of(low < scale[1].left ? low : mean, scale);
  }
  const double bias = kBias * camera_.scene_radius();
  for (std::size_t i = std::min(kMarks, removal.troubles.size()); i-- > 0;) {
    const ScreenPoint at = camera_.project(removal.troubles[i].place);
    raster_.disc(at, 16.0 * kOversample, kMark, 10.0 * bias);
    raster_.disc(at, 9.0 * kOversample, kMarkHeart, 11.0 * bias);
    raster_.disc(at, 5.0 * kOversample, kMark, 12.0 * bias);
  }
  return raster_.png(kOversample, colours, threads);
}

}  // namespace tiltfeed::sim
