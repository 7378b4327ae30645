#include "sim/engagement/engagement_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "sim/basics/text.h"
#include "sim/engagement/chip_gauge.h"

namespace tiltfeed::sim {
namespace {

constexpr double kAcross = 1200.0, kLeftEdge = 150.0, kRightEdge = 24.0, kRow = 150.0, kGap = 34.0,
                 kTopEdge = 44.0;
constexpr int kSlots = 500;

/// Mean and most of each slot of time.
struct Slot {
  double seconds = 0.0, sum = 0.0, most = 0.0;
};

double end_of(const std::vector<PlottedSpan>& spans) {
  double seconds = 0.0;
  for (const PlottedSpan& span : spans) seconds += span.seconds;
  return seconds;
}

std::array<Slot, kSlots> slots(const std::vector<PlottedSpan>& spans, double PlottedSpan::*value,
                               double end) {
  std::array<Slot, kSlots> all{};
  double at = 0.0;
  for (const PlottedSpan& span : spans) {
    // A span may reach over several slots.
    double from = at;
    at += span.seconds;
    while (from < at) {
      const int slot = std::clamp(static_cast<int>(from / end * kSlots), 0, kSlots - 1);
      const double to = slot + 1 == kSlots ? at : std::min(at, (slot + 1) * end / kSlots);
      const double share = std::max(to - from, 1e-9);
      all[slot].seconds += share, all[slot].sum += share * span.*value;
      all[slot].most = std::max(all[slot].most, span.*value);
      from += share;
    }
  }
  return all;
}

/// A line through the slots.
std::string curve(const std::array<Slot, kSlots>& all, bool most, double top, double scale,
                  const char* style) {
  std::string points;
  for (int i = 0; i < kSlots; ++i) {
    if (!(all[i].seconds > 0.0)) continue;
    const double value = most ? all[i].most : all[i].sum / all[i].seconds;
    points += text("%.1f,%.1f ", kLeftEdge + (kAcross - kLeftEdge - kRightEdge) * (i + 0.5) / kSlots,
                   top + kRow * (1.0 - std::min(1.0, value / scale)));
  }
  return text("<polyline fill='none' stroke-width='1' %s points='", style) + points + "'/>\n";
}

struct Row {
  const char *name, *unit;
  double PlottedSpan::*value;
  bool most;
};
constexpr std::array<Row, 4> kRows{Row{"feed", "mm/min, mean", &PlottedSpan::feed, false},
                                   Row{"load on an edge", "most, of the largest", &PlottedSpan::load, true},
                                   Row{"engaged angle", "degrees, most", &PlottedSpan::angle, true},
                                   Row{"removal", "mm3/min, mean", &PlottedSpan::rate, false}};

double most_of(const std::array<Slot, kSlots>& all, bool most) {
  double value = 0.0;
  for (const Slot& slot : all)
    if (slot.seconds > 0.0) value = std::max(value, most ? slot.most : slot.sum / slot.seconds);
  return value;
}

/// Loads as shares of the largest of their operation in `of`.
std::vector<PlottedSpan> by_largest(std::vector<PlottedSpan> spans, const std::vector<PlottedSpan>& of) {
  std::map<unsigned, double> largest;
  for (const PlottedSpan& span : of) largest[span.operation] = std::max(largest[span.operation], span.load);
  for (PlottedSpan& span : spans)
    if (const double most = largest[span.operation]; most > 0.0) span.load /= most;
  return spans;
}

}  // namespace

bool plotted_span(const std::string& line, PlottedSpan& span) {
  double way = 0.0, volume = 0.0, edge = 0.0, asked = 0.0;
  if (std::sscanf(line.c_str(), "%u,%*u,%*f,%*u,%*f,%lf,%lf,%lf,%*f,%*f,%lf,%*f,%lf,%lf", &span.operation,
                  &way, &volume, &span.angle, &edge, &asked, &span.seconds) != 7 ||
      !(span.seconds > 0.0))
    return false;
  span.feed = way / span.seconds * 60.0, span.rate = volume / span.seconds * 60.0;
  span.load = edge * std::pow(asked / span.seconds, kChipExponent);
  return true;
}

std::string engagement_svg(const std::vector<PlottedSpan>& program, const std::vector<PlottedSpan>& other) {
  const std::vector<PlottedSpan>& base = other.empty() ? program : other;
  const std::vector<PlottedSpan> now = by_largest(program, base), before = by_largest(other, base);
  const double end = std::max({end_of(now), end_of(before), 1e-3});
  const double tall = kTopEdge + kRows.size() * (kRow + kGap) + 10.0;
  std::string svg = text(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' width='%.0f' height='%.0f' "
      "font-family='sans-serif' font-size='13' fill='#223'>\n<rect width='100%%' height='100%%' "
      "fill='#fff'/>\n",
      kAcross, tall, kAcross, tall);
  svg += text("<text x='%.0f' y='22'>moves at feed, %.1f s", kLeftEdge, end_of(now));
  if (!before.empty()) svg += text(" <tspan fill='#999'>(before: %.1f s, grey)</tspan>", end_of(before));
  svg += "</text>\n";
  double top = kTopEdge;
  for (const Row& row : kRows) {
    const bool load = row.value == &PlottedSpan::load;
    const auto of_now = slots(now, row.value, end), of_before = slots(before, row.value, end);
    const double most = std::max({most_of(of_now, row.most), most_of(of_before, row.most), 1e-9});
    const double scale = load ? 1.25 : 1.05 * most;
    svg += text(
        "<rect x='%.0f' y='%.0f' width='%.0f' height='%.0f' fill='none' stroke='#bbc'/>\n"
        "<text x='6' y='%.0f'>%s</text>\n<text x='6' y='%.0f' font-size='10' fill='#667'>%s</text>\n"
        "<text x='%.0f' y='%.0f' font-size='10' text-anchor='end'>%.4g</text>\n",
        kLeftEdge, top, kAcross - kLeftEdge - kRightEdge, kRow, top + 40.0, row.name, top + 56.0, row.unit,
        kLeftEdge - 4.0, top + 10.0, scale);
    if (load)
      svg += text("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#c33' stroke-dasharray='6 4'/>\n",
                  kLeftEdge, kAcross - kRightEdge, top + kRow * 0.2, top + kRow * 0.2);
    if (!before.empty()) svg += curve(of_before, row.most, top, scale, "stroke='#aaa'");
    svg += curve(of_now, row.most, top, scale, "stroke='#1460aa'");
    top += kRow + kGap;
  }
  for (int i = 0; i <= 6; ++i)
    svg += text("<text x='%.0f' y='%.0f' font-size='10' text-anchor='%s'>%.0f s</text>\n",
                kLeftEdge + (kAcross - kLeftEdge - kRightEdge) * i / 6.0, top - kGap + 16.0,
                i == 6 ? "end" : "middle", end * i / 6.0);
  return svg + "</svg>\n";
}

}  // namespace tiltfeed::sim
