#include "daemon/measure/rest_picture.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

constexpr double kWide = 760.0, kLeft = 70.0, kRight = 20.0, kMapTop = 50.0, kMapTall = 240.0,
                 kBarsTop = 350.0, kBarsTall = 180.0, kTall = 580.0;
constexpr double kLargest = 16.0;  // radius of the largest circle
constexpr const char* kColours[] = {"#b3452c", "#3f7d3a", "#2f5fa8"};

std::string number(double value) { return decimal(value, 2); }

std::string text_at(double x, double y, const std::string& words, const char* anchor = "start") {
  std::string safe;
  for (const char c : words)
    safe += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return "<text x='" + number(x) + "' y='" + number(y) + "' text-anchor='" + anchor + "'>" + safe +
         "</text>\n";
}

std::string line(double x0, double y0, double x1, double y1, const char* look) {
  return "<line x1='" + number(x0) + "' y1='" + number(y0) + "' x2='" + number(x1) + "' y2='" + number(y1) +
         "' " + look + "/>\n";
}

/// Words to the picture's width or height.
struct Scale {
  double low = 0.0, high = 1.0, from = 0.0, to = 1.0;
  double operator()(double value) const { return from + (to - from) * (value - low) / (high - low); }
  void take(double value) { low = std::min(low, value), high = std::max(high, value); }
  void widen() {
    const double more = std::max(5.0, (high - low) * 0.06);
    low -= more, high += more;
  }
};

std::string map_of(const PivotFit& fit, const MachineModel& m, const std::vector<std::string>& names,
                   const std::vector<NextPlace>& next, double most) {
  const BallPlace first = fit.places.front().at;
  Scale across{first.rotary, first.rotary, kLeft, kWide - kRight};
  Scale up{first.tilt, first.tilt, kMapTop + kMapTall, kMapTop};
  for (const PlaceRest& one : fit.places) across.take(one.at.rotary), up.take(one.at.tilt);
  for (const NextPlace& one : next) across.take(one.at.rotary), up.take(one.at.tilt);
  for (Scale* scale : {&across, &up}) scale->widen();
  std::string svg = "<rect x='" + number(kLeft) + "' y='" + number(kMapTop) + "' width='" +
                    number(kWide - kLeft - kRight) + "' height='" + number(kMapTall) +
                    "' fill='none' stroke='#999'/>\n";
  for (const double share : {0.0, 0.5, 1.0}) {
    const double word = across.low + (across.high - across.low) * share;
    svg += text_at(across(word), kMapTop + kMapTall + 16, decimal(word, 0), "middle");
    const double other = up.low + (up.high - up.low) * share;
    svg += text_at(kLeft - 6, up(other) + 4, decimal(other, 0), "end");
  }
  svg +=
      text_at(kWide - kRight, kMapTop + kMapTall + 32, std::string(1, m.rotary.letter) + " degrees", "end");
  svg += text_at(8, kMapTop - 8,
                 std::string(1, m.tilt.letter) +
                     " degrees; a circle is a place, as large as its rest; "
                     "a cross is a place to add");
  for (std::size_t i = 0; i < fit.places.size(); ++i) {
    const PlaceRest& one = fit.places[i];
    const double radius = 2.0 + (most > 0 ? kLargest * length(one.rest) / most : 0.0);
    svg += "<circle cx='" + number(across(one.at.rotary)) + "' cy='" + number(up(one.at.tilt)) + "' r='" +
           number(radius) + "' fill='#2f5fa8' fill-opacity='0.35' stroke='#2f5fa8'><title>place ";
    for (const char c : names[i]) svg += c == '<' || c == '&' ? ' ' : c;
    svg += ": " + decimal(length(one.rest) * 1e3, 1) + " um</title></circle>\n";
  }
  for (const NextPlace& one : next) {
    const double x = across(one.at.rotary), y = up(one.at.tilt);
    svg += line(x - 6, y - 6, x + 6, y + 6, "stroke='#b3452c' stroke-width='2'");
    svg += line(x - 6, y + 6, x + 6, y - 6, "stroke='#b3452c' stroke-width='2'");
  }
  return svg;
}

std::string bars_of(const PivotFit& fit, double most) {
  const double top = std::max(most, 2.5 * fit.noise) * 1.05 + 1e-9;
  const Scale up{-top, top, kBarsTop + kBarsTall, kBarsTop};
  const double each = (kWide - kLeft - kRight) / static_cast<double>(fit.places.size());
  std::string svg = text_at(8, kBarsTop - 12,
                            "rest of each place in um: X red, Y green, Z blue; lines: two standard "
                            "deviations of a reading");
  for (const double level : {-2 * fit.noise, 0.0, 2 * fit.noise}) {
    svg += line(kLeft, up(level), kWide - kRight, up(level),
                level == 0.0 ? "stroke='#999'" : "stroke='#999' stroke-dasharray='4 3'");
    svg += text_at(kLeft - 6, up(level) + 4, decimal(level * 1e3, 1), "end");
  }
  for (std::size_t i = 0; i < fit.places.size(); ++i) {
    const Vec3 rest = fit.places[i].rest;
    const double parts[] = {rest.x, rest.y, rest.z};
    for (std::size_t k = 0; k < 3; ++k) {
      const double x = kLeft + each * (static_cast<double>(i) + 0.15 + 0.23 * static_cast<double>(k));
      const double y0 = up(std::max(0.0, parts[k])), y1 = up(std::min(0.0, parts[k]));
      svg += "<rect x='" + number(x) + "' y='" + number(y0) + "' width='" + number(each * 0.23) +
             "' height='" + number(y1 - y0) + "' fill='" + kColours[k] + "'/>\n";
    }
  }
  return svg + text_at(kWide - kRight, kBarsTop + kBarsTall + 18, "places in the order of the file", "end");
}

}  // namespace

std::string rest_picture(const PivotFit& fit, const MachineModel& machine,
                         const std::vector<std::string>& names, const std::vector<NextPlace>& next) {
  double most = 0.0;
  for (const PlaceRest& one : fit.places) most = std::max(most, length(one.rest));
  return "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 " + number(kWide) + " " + number(kTall) +
         "' font-family='sans-serif' font-size='12'>\n<rect width='100%' height='100%' fill='white'/>\n" +
         text_at(8, 20,
                 machine.name + ": " + std::to_string(fit.places.size()) + " places, noise of a reading " +
                     decimal(fit.noise * 1e3, 2) + " um, largest rest " + decimal(most * 1e3, 2) + " um") +
         map_of(fit, machine, names, next, most) + bars_of(fit, most) + "</svg>\n";
}

}  // namespace tiltfeed::daemon
