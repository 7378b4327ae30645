#include <algorithm>
#include <array>
#include <cmath>

#include "sim/basics/text.h"
#include "sim/report/report_page.h"

namespace tiltfeed::sim {
namespace {

constexpr double kWide = 1040.0, kLeft = 90.0, kRight = 40.0;

/// "1200", "0.25": as many digits as a label wants.
std::string label(double value) {
  if (std::abs(value) >= 100.0) return text("%.0f", value);
  return std::abs(value) >= 1.0 ? text("%.4g", value) : text("%.2g", value);
}

/// One plot: x is time, y runs from low (bottom) to high.
class Plot {
 public:
  Plot(const Removal& removal, double top, double tall, double low, double high)
      : removal_(removal), top_(top), tall_(tall), low_(low), high_(high > low ? high : low + 1.0) {}

  double x(std::size_t bin) const {
    return kLeft +
           (kWide - kLeft - kRight) * static_cast<double>(bin) / static_cast<double>(removal_.bins.size());
  }
  double y(double value) const {
    return top_ + tall_ * (1.0 - (std::clamp(value, low_, high_) - low_) / (high_ - low_));
  }
  std::string frame(const std::string& name, const std::string& unit) const {
    std::string svg = text("<rect class='plot' x='%.1f' y='%.1f' width='%.1f' height='%.1f'/>", kLeft, top_,
                           kWide - kLeft - kRight, tall_);
    svg += text("<text class='name' x='4' y='%.1f'>%s</text><text class='unit' x='4' y='%.1f'>%s</text>",
                top_ + 14.0, name.c_str(), top_ + 29.0, unit.c_str());
    for (const double v : {low_, high_})
      svg += text("<text class='tick' x='%.1f' y='%.1f'>%s</text>", kLeft - 5.0,
                  y(v) + (v == low_ ? 0.0 : 9.0), label(v).c_str());
    return svg;
  }
  /// The area between two values of each bin.
  std::string band(const char* style, const auto& low, const auto& high) const {
    std::string up, down;
    for (std::size_t b = 0; b < removal_.bins.size(); ++b) {
      const TimeBin& bin = removal_.bins[b];
      if (bin.low[0] > bin.high[0]) continue;
      const double a = y(high(bin)), z = y(low(bin));
      up += text("%.1f,%.1f %.1f,%.1f ", x(b), a, x(b + 1), a);
      down = text("%.1f,%.1f %.1f,%.1f ", x(b + 1), z + 0.6, x(b), z + 0.6) + down;
    }
    return text("<polygon class='%s' points='", style) + up + down + "'/>";
  }
  std::string level(const char* style, double value) const {
    if (value < low_ || value > high_) return "";
    return text("<line class='%s' x1='%.1f' y1='%.1f' x2='%.1f' y2='%.1f'/>", style, kLeft, y(value),
                kWide - kRight, y(value));
  }

 private:
  const Removal& removal_;
  double top_, tall_, low_, high_;
};

std::string hours(const Removal& r, double top) {
  std::string svg;
  for (int i = 0; i <= 4; ++i) {
    const double seconds = r.bin_seconds * static_cast<double>(r.bins.size()) * i / 4.0;
    svg += text("<text class='hour' x='%.1f' y='%.1f'>%s</text>", kLeft + (kWide - kLeft - kRight) * i / 4.0,
                top, clock_text(seconds).c_str());
  }
  return svg;
}

std::string svg_of(const char* what, double tall, const std::string& body) {
  return text("<svg viewBox='0 0 %.0f %.0f' role='group' aria-label='%s'>", kWide, tall, what) + body +
         "</svg>\n";
}

}  // namespace

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::lround(seconds));
  return text("%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string timeline_svg(const Removal& r) {
  double most = 0.0;
  for (const TimeBin& bin : r.bins) most = std::max(most, bin.removed / r.bin_seconds * 60.0);
  const Plot rate(r, 8.0, 130.0, 0.0, most > 0.0 ? most : 1.0);
  std::string svg = rate.frame("removal", "mm³/min");
  svg += rate.band(
      "rate", [](const TimeBin&) { return 0.0; },
      [&](const TimeBin& bin) { return bin.removed / r.bin_seconds * 60.0; });
  const Plot share(r, 150.0, 36.0, 0.0, 1.0);
  svg += share.frame("moves", "share");
  const auto part = [&](double seconds) { return seconds / r.bin_seconds; };
  svg += share.band(
      "cutting", [](const TimeBin&) { return 0.0; },
      [&](const TimeBin& b) { return part(b.cutting - b.air); });
  svg += share.band(
      "air", [&](const TimeBin& b) { return part(b.cutting - b.air); },
      [&](const TimeBin& b) { return part(b.cutting); });
  svg += share.band(
      "rapid", [&](const TimeBin& b) { return part(b.cutting); },
      [&](const TimeBin& b) { return part(b.cutting + b.rapid); });
  for (std::size_t i = 0; i < r.troubles.size(); ++i) {
    const double x =
        rate.x(0) +
        (rate.x(r.bins.size()) - rate.x(0)) *
            std::clamp(r.troubles[i].time / (r.bin_seconds * static_cast<double>(r.bins.size())), 0.0, 1.0);
    svg += text(
        "<a href='#trouble-%zu' aria-label='worst place %zu'><line class='trouble' x1='%.1f' y1='8' "
        "x2='%.1f' y2='186'/></a>",
        i + 1, i + 1, x, x);
  }
  return svg_of("removal rate and kinds of moves over time", 212.0, svg + hours(r, 204.0));
}

std::string axes_svg(const Removal& r, const MachineModel& m) {
  struct Axis {
    std::string name, unit;
    double min, max, velocity;
  };
  const std::array<Axis, 5> axes{
      Axis{"X", "mm", m.x.min, m.x.max, m.x.velocity}, Axis{"Y", "mm", m.y.min, m.y.max, m.y.velocity},
      Axis{"Z", "mm", m.z.min, m.z.max, m.z.velocity},
      Axis{std::string(1, m.tilt.letter), "deg", m.tilt.min, m.tilt.max, m.tilt.velocity},
      Axis{std::string(1, m.rotary.letter), "deg", m.rotary.min, m.rotary.max, m.rotary.velocity}};
  std::string svg;
  double top = 8.0;
  for (std::size_t k = 0; k < axes.size(); ++k, top += 160.0) {
    const Axis& axis = axes[k];
    const double span = std::max(1e-3, r.travel_high[k] - r.travel_low[k]);
    const Plot place(r, top, 84.0, std::max(axis.min, r.travel_low[k] - 0.1 * span),
                     std::min(axis.max, r.travel_high[k] + 0.1 * span));
    svg += place.frame(axis.name, axis.unit);
    svg += place.band(
        "place", [k](const TimeBin& b) { return b.low[k]; }, [k](const TimeBin& b) { return b.high[k]; });
    svg += place.level("limit", axis.min) + place.level("limit", axis.max);
    const Plot speed(r, top + 94.0, 40.0, 0.0, axis.velocity);
    svg += speed.frame("speed", axis.unit + "/min");
    svg += speed.band(
        "speed", [](const TimeBin&) { return 0.0; }, [k](const TimeBin& b) { return b.speed[k]; });
    svg += speed.level("limit", axis.velocity);
  }
  return svg_of("place and speed of each axis over time", top + 18.0, svg + hours(r, top + 8.0));
}

}  // namespace tiltfeed::sim
