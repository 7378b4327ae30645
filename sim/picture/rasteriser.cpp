#include "sim/picture/rasteriser.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "sim/basics/workers.h"

namespace tiltfeed::sim {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
// Far more than rounding takes from depths as floats, or from areas.
constexpr double kSlack = 1e-6;
constexpr int kHollowSamples = 24, kHollowStep = 2;
// Successive directions of the samples turn by the golden angle, so that they spread evenly.
constexpr double kGoldenAngle = 2.399963229728653;

std::uint8_t to_srgb(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(s * 255.0));
}

/// The same by a table: pictures ask millions of times.
class ToSrgb {
 public:
  ToSrgb() {
    for (int i = 0; i <= kSteps; ++i) byte_[i] = to_srgb(static_cast<double>(i) / kSteps);
  }
  std::uint8_t operator()(double linear) const {
    const auto i = static_cast<int>(std::clamp(linear, 0.0, 1.0) * kSteps);
    // Within a step without a change of the byte there is no other.
    return byte_[i] == byte_[std::min(i + 1, kSteps)] ? byte_[i] : to_srgb(linear);
  }

 private:
  static constexpr int kSteps = 16384;
  std::array<std::uint8_t, kSteps + 1> byte_;
};

}  // namespace

Rasteriser::Rasteriser(int width, int height, std::array<Colour, 2> background)
    : width_(width), height_(height), depth_(static_cast<std::size_t>(width) * height, kFar), spots_(width) {
  colour_.reserve(depth_.size());
  for (int y = 0; y < height; ++y) {
    const Colour c = background[0] + (background[1] - background[0]) * (static_cast<double>(y) / height);
    colour_.insert(colour_.end(), static_cast<std::size_t>(width), floats(c));
  }
}

Rasteriser::Outline Rasteriser::outline(const std::array<ScreenPoint, 3>& p) const {
  const auto [x_low, x_high] = std::minmax({p[0].x, p[1].x, p[2].x});
  const auto [y_low, y_high] = std::minmax({p[0].y, p[1].y, p[2].y});
  const auto [least, most] = std::minmax({p[0].depth, p[1].depth, p[2].depth});
  const double slack = kSlack * std::max(std::abs(least), std::abs(most));
  Outline o{p,
            (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y),
            static_cast<float>(least - slack),
            std::max(0, static_cast<int>(std::ceil(x_low - 0.5))),
            std::min(width_ - 1, static_cast<int>(std::floor(x_high - 0.5))),
            std::max(0, static_cast<int>(std::ceil(y_low - 0.5))),
            std::min(height_ - 1, static_cast<int>(std::floor(y_high - 0.5)))};
  if (o.area == 0.0) o.y1 = o.y0 - 1;
  return o;
}

std::span<const Rasteriser::Spot> Rasteriser::cover(const Outline& o, int y) {
  const auto& p = o.corners;
  const double x01 = p[1].x - p[0].x, y01 = p[1].y - p[0].y, x02 = p[2].x - p[0].x, y02 = p[2].y - p[0].y;
  const double dy = y + 0.5 - p[0].y, area = o.area, sign = area > 0.0 ? 1.0 : -1.0;
  const double all = std::abs(area) * (1.0 + kSlack), x02_dy = x02 * dy, x01_dy = x01 * dy, left = p[0].x;
  float* const depths = &depth_[at(0, y)];
  Spot* spot = spots_.data();
  for (int x = o.x0; x <= o.x1; ++x) {
    if (depths[x] < o.nearest) continue;
    // Half of the box is beside the triangle, which is seen before anything is divided.
    const double dx = x + 0.5 - left, over_b = dx * y02 - x02_dy, over_c = x01_dy - dx * y01;
    if (over_b * sign < 0.0 || over_c * sign < 0.0 || (over_b + over_c) * sign > all) continue;
    const double b = over_b / area, c = over_c / area, a = 1.0 - b - c;
    if (a < 0.0) continue;
    const auto depth = static_cast<float>(a * p[0].depth + b * p[1].depth + c * p[2].depth);
    if (depth >= depths[x]) continue;
    depths[x] = depth;
    *spot++ = {at(x, y), a, b, c};
  }
  return {spots_.data(), spot};
}

void Rasteriser::mix(int x, int y, double depth, Colour colour, double alpha) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_ || depth > static_cast<double>(depth_[at(x, y)])) return;
  if (!owner_.empty()) owner_[at(x, y)] = kNobody;
  auto& pixel = colour_[at(x, y)];
  const double k[3] = {colour.x, colour.y, colour.z};
  for (int i = 0; i < 3; ++i)
    pixel[i] = static_cast<float>(static_cast<double>(pixel[i]) * (1.0 - alpha) + k[i] * alpha);
}

void Rasteriser::line(ScreenPoint from, ScreenPoint to, double thickness, Colour colour, double alpha,
                      double bias) {
  const double dx = to.x - from.x, dy = to.y - from.y, whole = std::hypot(dx, dy), half = thickness / 2.0;
  const double surely_in = half * half * (1.0 - kSlack), surely_out = half * half * (1.0 + kSlack);
  const int y0 = std::max(0, static_cast<int>(std::floor(std::min(from.y, to.y) - half)));
  const int y1 = std::min(height_ - 1, static_cast<int>(std::ceil(std::max(from.y, to.y) + half)));
  for (int y = y0; y <= y1; ++y) {
    // The row's part of the band round the line, a little wide; each pixel is then tested exactly.
    double low = std::min(from.x, to.x), high = std::max(from.x, to.x);
    if (std::abs(dy) > 1e-9) {
      const double slack = half * whole / std::abs(dy) + 1.0, at_row = from.x + (y + 0.5 - from.y) * dx / dy;
      low = std::max(low, at_row - slack), high = std::min(high, at_row + slack);
    }
    const int x0 = std::max(0, static_cast<int>(std::floor(low - half)));
    const int x1 = std::min(width_ - 1, static_cast<int>(std::ceil(high + half)));
    for (int x = x0; x <= x1; ++x) {
      const double px = x + 0.5 - from.x, py = y + 0.5 - from.y;
      const double f = whole > 0.0 ? std::clamp((px * dx + py * dy) / (whole * whole), 0.0, 1.0) : 0.0;
      // Only the half-open piece at the start: a chain of lines covers each joint once.
      if (f >= 1.0 && whole > 0.0) continue;
      const double off_x = px - f * dx, off_y = py - f * dy, off2 = off_x * off_x + off_y * off_y;
      if (off2 > surely_out || (off2 > surely_in && std::hypot(off_x, off_y) > half)) continue;
      mix(x, y, from.depth + f * (to.depth - from.depth) - bias, colour, alpha);
    }
  }
}

void Rasteriser::disc(ScreenPoint centre, double diameter, Colour colour, double bias) {
  line(centre, centre, diameter, colour, 1.0, bias);
}

void Rasteriser::shade_hollows(double radius, double range, double strength) {
  struct Offset {
    int x, y;
    std::ptrdiff_t step;  // in memory
  };
  std::array<Offset, kHollowSamples> offset;
  int reach = 0;
  for (int i = 0; i < kHollowSamples; ++i) {
    const double r = radius * std::sqrt((i + 1.0) / kHollowSamples), turn = kGoldenAngle * i;
    const int ox = static_cast<int>(std::lround(r * std::cos(turn))),
              oy = static_cast<int>(std::lround(r * std::sin(turn)));
    offset[i] = {ox, oy, static_cast<std::ptrdiff_t>(oy) * width_ + ox};
    reach = std::max({reach, std::abs(ox), std::abs(oy)});
  }
  // How much nearer what is round (x, y) is, each sample 0..1. Opposite samples together: a plane's slope
  // cancels out, what is left is hollow or ridge.
  const auto covered = [&](int x, int y) {
    const float* const centre = &depth_[at(x, y)];
    const double here = static_cast<double>(*centre);
    const auto known = [&](float d) { return d == kFar ? here + range : static_cast<double>(d); };
    std::array<double, kHollowSamples> nearer;
    if (x >= reach && y >= reach && x < width_ - reach && y < height_ - reach) {
      for (int i = 0; i < kHollowSamples; ++i)
        nearer[i] = here - 0.5 * (known(centre[offset[i].step]) + known(centre[-offset[i].step]));
    } else {
      const auto inside = [&](int sx, int sy) {
        return known(depth_[at(std::clamp(sx, 0, width_ - 1), std::clamp(sy, 0, height_ - 1))]);
      };
      for (int i = 0; i < kHollowSamples; ++i)
        nearer[i] = here - 0.5 * (inside(x + offset[i].x, y + offset[i].y) +
                                  inside(x - offset[i].x, y - offset[i].y));
    }
    for (double& share : nearer) share = std::clamp(share / range, 0.0, 1.0);
    double sum = 0.0;
    for (const double share : nearer) sum += share;
    return sum;
  };
  // One look for each square of kHollowStep pixels: what is shaded is far wider.
  for (int y0 = 0; y0 < height_; y0 += kHollowStep) {
    for (int x0 = 0; x0 < width_; x0 += kHollowStep) {
      const int x1 = std::min(width_, x0 + kHollowStep), y1 = std::min(height_, y0 + kHollowStep);
      int x = x0, y = y0;
      while (y < y1 && depth_[at(x, y)] == kFar)
        if (++x == x1) x = x0, ++y;
      if (y == y1) continue;
      const auto keep =
          static_cast<float>(1.0 - strength * std::min(1.0, 2.0 * covered(x, y) / kHollowSamples));
      for (int sy = y0; sy < y1; ++sy)
        for (int sx = x0; sx < x1; ++sx)
          if (depth_[at(sx, sy)] != kFar)
            for (float& channel : colour_[at(sx, sy)]) channel *= keep;
    }
  }
}

Result<std::string> Rasteriser::png(int factor, const std::vector<Colour>& by_owner, int threads) const {
  const int w = width_ / factor, h = height_ / factor;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(w) * h * 3);
  const ToSrgb to_byte;
  in_parallel(static_cast<std::size_t>(h), threads, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < w; ++x) {
      double sum[3] = {};
      for (int j = 0; j < factor; ++j) {
        for (int i = 0; i < factor; ++i) {
          const std::size_t pixel = at(x * factor + i, y * factor + j);
          const auto& [red, green, blue] = colour_[pixel];
          const std::uint32_t owner = owner_.empty() ? kNobody : owner_[pixel];
          const Colour tint = owner < by_owner.size() ? by_owner[owner] : Colour{1.0, 1.0, 1.0};
          sum[0] += static_cast<double>(red) * tint.x, sum[1] += static_cast<double>(green) * tint.y,
              sum[2] += static_cast<double>(blue) * tint.z;
        }
      }
      for (int k = 0; k < 3; ++k)
        bytes[(static_cast<std::size_t>(y) * w + x) * 3 + k] = to_byte(sum[k] / (factor * factor));
    }
  });
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(w), image.height = static_cast<png_uint_32>(h);
  image.format = PNG_FORMAT_RGB, image.flags = PNG_IMAGE_FLAG_FAST;
  std::string file(PNG_IMAGE_PNG_SIZE_MAX(image), '\0');
  png_alloc_size_t size = file.size();
  if (!png_image_write_to_memory(&image, file.data(), &size, 0, bytes.data(), 0, nullptr))
    return fail(Code::kIo, std::string("a picture cannot be made: ") + image.message);
  file.resize(size);
  return file;
}

}  // namespace tiltfeed::sim
