// A section of the tyre segment, flattened and brought back, with its tool axes.

#include <algorithm>
#include <cmath>

#include "kinematics/basics/units.h"
#include "pathgen/axis/deformation.h"
#include "sim/parts/parts.h"
#include "tests/pictures/pictures.h"
#include "tests/pictures/svg.h"

namespace tiltfeed::pictures {
using namespace pathgen;
namespace {

constexpr double kTheta = 1.0;        // of the section, degrees
constexpr double kCircle = 280.0;     // radius of the circle through which all tool axes pass, mm
constexpr double kDeepest = 90.5;     // from the circle: the cavity is nearer, the back is not
constexpr double kChord = 3.0;        // mm, between places of the section
constexpr double kSame = 1e-6;        // mm, by which cuts of neighbouring facets may differ
constexpr double kBackWithin = 1e-9;  // mm, what there and back may differ by
constexpr double kScale = 2.4;        // px a mm

struct Segment {
  Point<Part> from, to;
};

/// Where the half plane at kTheta cuts the part, in no order.
std::vector<Segment> cuts_of(const sim::Triangles& part) {
  const double t = Angle::from_degrees(kTheta).radians();
  const Vec3 across{std::cos(t), 0.0, std::sin(t)};
  std::vector<Segment> found;
  for (const auto& facet : part) {
    std::vector<Point<Part>> ends;
    for (int i = 0; i < 3; ++i) {
      const Point<Part> a = facet[i], b = facet[(i + 1) % 3];
      const double u = dot(from_origin(a), across), v = dot(from_origin(b), across);
      if ((u < 0.0) != (v < 0.0)) ends.push_back(lerp(a, b, u / (u - v)));
    }
    if (ends.size() == 2) found.push_back({ends[0], ends[1]});
  }
  return found;
}

/// The same as one closed row of places, kChord apart at most.
Result<std::vector<Point<Part>>> outline_of(std::vector<Segment> cuts) {
  std::vector<Point<Part>> outline;
  Point<Part> end = cuts.front().from;
  while (!cuts.empty()) {
    const auto next = std::find_if(cuts.begin(), cuts.end(), [&](const Segment& s) {
      return distance(s.from, end) < kSame || distance(s.to, end) < kSame;
    });
    if (next == cuts.end()) return fail(Code::kMesh, "the section of the tyre is not one closed line");
    const Point<Part> to = distance(next->from, end) < kSame ? next->to : next->from;
    const int pieces = static_cast<int>(distance(end, to) / kChord) + 1;
    for (int i = 0; i < pieces; ++i) outline.push_back(lerp(end, to, static_cast<double>(i) / pieces));
    end = to;
    *next = cuts.back();
    cuts.pop_back();
  }
  return outline;
}

/// Place in the half plane: y, and how far below the y axis.
At in_plane(Point<Part> p) { return {p.y, -std::hypot(p.x, p.z)}; }

AxisFrame frame() {
  AxisFrame f;
  f.mode = AxisMode::kCircle;
  f.sense = Sense::kInward;
  f.t = {1, 0, 0}, f.n = {0, 0, -1};
  f.circle_radius = kCircle;
  return f;
}

/// Tool axes from the surface to the circle, in part space and in flat space.
void axes(Svg& svg, const Deformation& map, const Plot& part, const Plot& flat) {
  const double x = Angle::from_degrees(kTheta).radians() * map.scale_x();
  for (int phi = -50; phi <= 50; phi += 10) {
    const double y = Angle::from_degrees(phi).radians() * map.scale_y();
    const AxisLine line = map.axis_line(x, y);
    const double from = -80.0, to = -16.0;
    const std::string look = "stroke=\"#0f766e\"";
    svg.line(part.at(in_plane(line.base + line.axis * from)), part.at(in_plane(line.base + line.axis * to)),
             look);
    svg.arrow(part.at(in_plane(line.base + line.axis * from)), part.at(in_plane(line.base + line.axis * to)),
              "#0f766e");
    svg.line(flat.at({y, from}), flat.at({y, to}), look);
    svg.arrow(flat.at({y, from}), flat.at({y, to}), "#0f766e");
  }
}

}  // namespace

Result<void> draw_deformation(const std::string& file) {
  const auto outline = outline_of(cuts_of(sim::tyre_segment()));
  if (!outline) return tl::unexpected(outline.error());
  double sum = 0.0;
  int count = 0;
  const Deformation unscaled(frame(), 1.0);
  for (const Point<Part> p : *outline)
    if (const double rho = unscaled.distances(p).rho; rho < kDeepest) sum += rho, ++count;
  const Deformation map(frame(), sum / count);

  Line part_line, flat_line, back_line;
  for (const Point<Part> p : *outline) {
    const Point<Flat> f = map.flatten(p);
    const Point<Part> back = map.unflatten(f);
    if (distance(p, back) > kBackWithin) return fail(Code::kInput, "the deformation does not lead back");
    part_line.push_back(in_plane(p)), flat_line.push_back({f.y, f.z}), back_line.push_back(in_plane(back));
  }

  Svg svg(900, 510, "A section of the tyre segment in part space and in flat space");
  const Plot part = even_plot({55, 80}, {-78, -415}, {78, -275}, kScale);
  const Plot flat = even_plot({480, 80}, {-85, -155}, {85, 5}, kScale);
  part.grid(svg, {20, 20}, "y, mm", "z, mm");
  flat.grid(svg, {20, 20}, "y' = R Phi, mm, with R = " + fixed(sum / count, 1) + " mm", "z' = -rho, mm");
  const std::string solid = "fill=\"#d0d4da\" stroke=\"#333\"";
  svg.path(part.at(part_line), solid, true);
  svg.path(flat.at(flat_line), solid, true);
  for (std::size_t i = 0; i < back_line.size(); i += 4)
    svg.circle(part.at(back_line[i]), 1.8, "fill=\"#c2410c\"");
  axes(svg, map, part, flat);
  svg.circle(part.at(At{0, -kCircle}), 3.5, "fill=\"#1d4ed8\"");
  svg.line(flat.at({-70, 0}), flat.at({70, 0}), "stroke=\"#1d4ed8\" stroke-width=\"3\"");
  svg.text({55, 24}, "Part space: tool axes meet in the circle", "font-size=\"14\"");
  svg.text({480, 24}, "Flat space: every tool axis is +z'", "font-size=\"14\"");
  svg.circle({487, 40}, 3.5, "fill=\"#1d4ed8\"");
  svg.text({495, 44}, "the circle, spread out");
  svg.line({648, 40}, {672, 40}, "stroke=\"#0f766e\"");
  svg.arrow({648, 40}, {672, 40}, "#0f766e");
  svg.text({678, 44}, "tool axes, to the shank");
  svg.circle({155, 40}, 1.8, "fill=\"#c2410c\"");
  svg.text({163, 44}, "brought back from flat space");
  svg.circle({62, 40}, 3.5, "fill=\"#1d4ed8\"");
  svg.text({70, 44}, "the circle");
  return svg.write(file);
}

}  // namespace tiltfeed::pictures
