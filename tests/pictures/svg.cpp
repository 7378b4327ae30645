#include "tests/pictures/svg.h"

#include <cmath>
#include <cstdio>
#include <fstream>

namespace tiltfeed::pictures {
namespace {

constexpr const char* kText = "#222";
constexpr const char* kGrid = "#ddd";

std::string pair(const char* x, double x_value, const char* y, double y_value) {
  return std::string(" ") + x + "=\"" + fixed(x_value, 1) + "\" " + y + "=\"" + fixed(y_value, 1) + "\"";
}

std::string escaped(const std::string& words) {
  std::string out;
  for (const char c : words) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  std::string number = text;
  if (number.find_first_not_of("-0.") == std::string::npos && number.front() == '-') number.erase(0, 1);
  return number;
}

Svg::Svg(int width, int height, const std::string& title) {
  const std::string w = std::to_string(width), h = std::to_string(height);
  body_ = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + w + "\" height=\"" + h +
          "\" viewBox=\"0 0 " + w + " " + h +
          "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"none\">\n<title>" + escaped(title) +
          "</title>\n<rect width=\"" + w + "\" height=\"" + h + "\" fill=\"#fff\"/>\n";
}

void Svg::line(At from, At to, const std::string& look) {
  body_ += "<line" + pair("x1", from.x, "y1", from.y) + pair("x2", to.x, "y2", to.y) + " " + look + "/>\n";
}

void Svg::path(const Line& places, const std::string& look, bool closed) {
  body_ += closed ? "<polygon points=\"" : "<polyline points=\"";
  for (std::size_t i = 0; i < places.size(); ++i)
    body_ += (i > 0 ? " " : "") + fixed(places[i].x, 1) + "," + fixed(places[i].y, 1);
  body_ += "\" " + look + "/>\n";
}

void Svg::circle(At centre, double radius, const std::string& look) {
  body_ +=
      "<circle" + pair("cx", centre.x, "cy", centre.y) + " r=\"" + fixed(radius, 1) + "\" " + look + "/>\n";
}

void Svg::box(At corner, double width, double height, const std::string& look) {
  body_ += "<rect" + pair("x", corner.x, "y", corner.y) + pair("width", width, "height", height) + " " +
           look + "/>\n";
}

void Svg::text(At place, const std::string& words, const std::string& look) {
  body_ += "<text" + pair("x", place.x, "y", place.y) + " fill=\"" + kText + "\" " + look + ">" +
           escaped(words) + "</text>\n";
}

void Svg::arrow(At from, At to, const std::string& colour) {
  const double way = std::hypot(to.x - from.x, to.y - from.y);
  if (way < 1e-9) return;
  const At ahead{(to.x - from.x) / way, (to.y - from.y) / way};
  const At back{to.x - 8 * ahead.x, to.y - 8 * ahead.y};
  path({to,
        {back.x - 3.5 * ahead.y, back.y + 3.5 * ahead.x},
        {back.x + 3.5 * ahead.y, back.y - 3.5 * ahead.x}},
       "fill=\"" + colour + "\"", true);
}

Result<void> Svg::write(const std::string& file) const {
  std::ofstream out(file, std::ios::binary);
  out << body_ << "</svg>\n";
  out.close();
  if (!out) return fail(Code::kIo, "cannot write '" + file + "': is it inside the checkout, and writable?");
  return {};
}

Line straightened(const Line& line, double tolerance) {
  if (line.size() < 3) return line;
  const At a = line.front(), b = line.back();
  const double way = std::hypot(b.x - a.x, b.y - a.y);
  double most = 0.0;
  std::size_t at = 0;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    const At d{line[i].x - a.x, line[i].y - a.y};
    const double off =
        way > 0.0 ? std::abs(d.x * (b.y - a.y) - d.y * (b.x - a.x)) / way : std::hypot(d.x, d.y);
    if (off > most) most = off, at = i;
  }
  if (most <= tolerance) return {a, b};
  const auto middle = line.begin() + static_cast<std::ptrdiff_t>(at);
  Line out = straightened({line.begin(), middle + 1}, tolerance);
  const Line rest = straightened({middle, line.end()}, tolerance);
  out.insert(out.end(), rest.begin() + 1, rest.end());
  return out;
}

void legend(Svg& svg, At place, const std::string& look, const std::string& words) {
  svg.line({place.x, place.y - 4}, {place.x + 24, place.y - 4}, look);
  svg.text({place.x + 30, place.y}, words);
}

At Plot::at(At p) const {
  return {corner.x + (p.x - low.x) / (high.x - low.x) * width,
          corner.y + (high.y - p.y) / (high.y - low.y) * height};
}

Line Plot::at(const Line& places) const {
  Line out;
  for (const At p : places) out.push_back(at(p));
  return out;
}

void Plot::grid(Svg& svg, At step, const std::string& x, const std::string& y, int decimals) const {
  const std::string look = std::string("stroke=\"") + kGrid + "\"";
  for (double i = std::ceil(low.x / step.x - 1e-9); i * step.x <= high.x + 1e-9; ++i) {
    const At foot = at({i * step.x, low.y});
    svg.line(foot, {foot.x, corner.y}, look);
    svg.text({foot.x, foot.y + 16}, fixed(i * step.x, decimals), "text-anchor=\"middle\" font-size=\"11\"");
  }
  for (double i = std::ceil(low.y / step.y - 1e-9); i * step.y <= high.y + 1e-9; ++i) {
    const At left = at({low.x, i * step.y});
    svg.line(left, {corner.x + width, left.y}, look);
    svg.text({left.x - 6, left.y + 4}, fixed(i * step.y, decimals), "text-anchor=\"end\" font-size=\"11\"");
  }
  svg.text({corner.x + width, corner.y + height + 32}, x, "text-anchor=\"end\"");
  svg.text({corner.x - 30, corner.y - 12}, y);
}

Plot even_plot(At corner, At low, At high, double per_mm) {
  return {corner, (high.x - low.x) * per_mm, (high.y - low.y) * per_mm, low, high};
}

}  // namespace tiltfeed::pictures
