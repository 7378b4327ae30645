// The upper envelope along a line: its points, the straight moves between them, and the tool at some of them.

#include "pathgen/envelope/envelope.h"

#include "pathgen/envelope/thinning.h"
#include "tests/pictures/pictures.h"
#include "tests/pictures/section_part.h"

namespace tiltfeed::pictures {
using namespace pathgen;
namespace {

constexpr const char* kFound = "fill=\"#fff\" stroke=\"#1d4ed8\"";
constexpr double kTolerance = 0.05;  // mm; coarse, so that single points can be seen

void tool(Svg& svg, const Plot& plot, const EnvelopePoint& point) {
  const double r = kBall * plot.per_x();
  const At c = plot.at({point.flat.x, point.flat.z});
  const std::string look = "stroke=\"#777\" stroke-dasharray=\"4 3\"";
  svg.circle(c, r, look);
  svg.line({c.x - r, c.y}, {c.x - r, c.y - r - 12}, look);
  svg.line({c.x + r, c.y}, {c.x + r, c.y - r - 12}, look);
  const Vec3 n = point.normal * kBall;
  svg.line(c, plot.at({point.flat.x - n.x, point.flat.z - n.z}), "stroke=\"#c2410c\"");
}

void patches(Svg& svg, const Plot& plot, const ClField& field) {
  for (PatchId patch = 0; patch < field.surface.patch_count(); ++patch) {
    Line places;
    for (int i = -50; i <= 670; ++i) {
      ClHit hit;
      if (field.surface.top(patch, field.deformation.axis_line(i * 0.1, 0.0), hit)) {
        places.push_back({i * 0.1, hit.z});
        continue;
      }
      if (places.size() > 1) svg.path(straightened(plot.at(places), 0.05), "stroke=\"#9db4d8\"");
      places.clear();
    }
    if (places.size() > 1) svg.path(straightened(plot.at(places), 0.05), "stroke=\"#9db4d8\"");
  }
}

}  // namespace

Result<void> draw_envelope(const std::string& file) {
  const auto section = section_field();
  if (!section) return tl::unexpected(section.error());
  const ClField& field = *(*section)->field;
  EnvelopeOptions options;
  options.tolerance = kTolerance;
  Envelope envelope(field.surface, field.deformation, field.index, options);
  const LineEnvelope found = envelope.along({.x = -6.0, .y = 0.0, .length = 75.0});

  Svg svg(900, 340, "The upper envelope along a line");
  const Plot plot = section_plot(svg, {45, 64});
  patches(svg, plot, field);
  std::size_t points = 0, kept = 0;
  for (const Pass& pass : found.passes) {
    const Pass thin = thinned(pass, kTolerance, options);
    points += pass.size(), kept += thin.size();
    Line moves;
    for (const EnvelopePoint& p : thin) moves.push_back({p.flat.x, p.flat.z});
    svg.path(plot.at(moves), "stroke=\"#1d4ed8\" stroke-width=\"2\"");
    for (const EnvelopePoint& p : pass) svg.circle(plot.at({p.flat.x, p.flat.z}), 2.2, kFound);
    for (const At p : moves) svg.circle(plot.at(p), 3.0, "fill=\"#1d4ed8\"");
  }
  for (const double x : {3.0, 15.0, 24.0, 31.0, 41.0, 55.0})
    if (const auto point = envelope.at(x, 0.0)) tool(svg, plot, *point);
  legend(svg, {45, 22}, "stroke=\"#1d4ed8\" stroke-width=\"2\"", "upper envelope");
  svg.circle({190, 18}, 2.2, kFound);
  svg.text({198, 22}, std::to_string(points) + " points found, within " + fixed(kTolerance, 2) + " mm");
  svg.circle({412, 18}, 3.0, "fill=\"#1d4ed8\"");
  svg.text({420, 22}, std::to_string(kept) + " kept");
  legend(svg, {490, 22}, "stroke=\"#9db4d8\"", "patches");
  legend(svg, {600, 22}, "stroke=\"#777\" stroke-dasharray=\"4 3\"", "tool");
  legend(svg, {690, 22}, "stroke=\"#c2410c\"", "centre to contact");
  return svg.write(file);
}

}  // namespace tiltfeed::pictures
