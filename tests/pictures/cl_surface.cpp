// The CL surface of a small part in a section: every patch, in the colour of the feature that it belongs to.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/pictures/pictures.h"
#include "tests/pictures/section_part.h"

namespace tiltfeed::pictures {
using namespace pathgen;
namespace {

constexpr double kStep = 0.01;  // mm, between two places that are asked
constexpr int kPlaces = 7201;
constexpr const char* kColour[] = {"#c2410c", "#15803d", "#1d4ed8"};  // vertex, edge, facet

/// One unbroken piece of a patch in the section.
struct Piece {
  Line places;
  std::uint32_t corners = 0;  ///< of its feature
  bool on_top = false;
};

double x_of(int i) { return -5.0 + i * kStep; }

/// The highest patch at each place that is asked.
std::vector<double> highest(const ClField& field) {
  std::vector<double> top(kPlaces, -1e9);
  for (int i = 0; i < kPlaces; ++i)
    for (PatchId patch = 0; patch < field.surface.patch_count(); ++patch)
      if (ClHit hit; field.surface.top(patch, field.deformation.axis_line(x_of(i), 0.0), hit))
        top[i] = std::max(top[i], hit.z);
  return top;
}

void add(std::vector<Piece>& pieces, const ClField& field, PatchId patch, const std::vector<double>& tops) {
  bool open = false;
  for (int i = 0; i < kPlaces; ++i) {
    ClHit hit;
    if (!field.surface.top(patch, field.deformation.axis_line(x_of(i), 0.0), hit)) {
      open = false;
      continue;
    }
    const bool on_top = hit.z >= tops[i] - 1e-6;
    if (!open || pieces.back().on_top != on_top) {
      Piece piece{{}, field.surface.core(patch).count, on_top};
      if (open) piece.places.push_back(pieces.back().places.back());
      pieces.push_back(std::move(piece));
    }
    pieces.back().places.push_back({x_of(i), hit.z});
    open = true;
  }
}

void tool(Svg& svg, const Plot& plot, At centre) {
  const double r = kBall * plot.per_x();
  const At c = plot.at(centre);
  svg.circle(c, r, "stroke=\"#888\" stroke-dasharray=\"4 3\"");
  svg.line({c.x, c.y - r - 14}, c, "stroke=\"#888\" stroke-dasharray=\"8 3 2 3\"");
  svg.circle(c, 2.5, "fill=\"#333\"");
}

}  // namespace

Result<void> draw_cl_surface(const std::string& file) {
  const auto section = section_field();
  if (!section) return tl::unexpected(section.error());
  const ClField& field = *(*section)->field;
  const std::vector<double> tops = highest(field);
  std::vector<Piece> pieces;
  for (PatchId patch = 0; patch < field.surface.patch_count(); ++patch) add(pieces, field, patch, tops);

  Svg svg(900, 340, "CL surface of a ball over a small part, in a section");
  const Plot plot = section_plot(svg, {45, 64});
  for (const bool on_top : {false, true})
    for (const Piece& piece : pieces)
      if (piece.on_top == on_top && piece.places.size() > 1)
        svg.path(straightened(plot.at(piece.places), 0.05),
                 std::string("stroke=\"") + kColour[piece.corners - 1] + "\" " +
                     (on_top ? "stroke-width=\"3\"" : "stroke-width=\"1.2\" stroke-dasharray=\"3 2\""));
  for (const double x : {12.0, 21.0, 33.0, 40.6})
    tool(svg, plot, {x, tops[static_cast<std::size_t>(std::lround((x + 5.0) / kStep))]});
  legend(svg, {45, 22}, std::string("stroke-width=\"3\" stroke=\"") + kColour[2] + "\"", "patch of a facet");
  legend(svg, {190, 22}, std::string("stroke-width=\"3\" stroke=\"") + kColour[1] + "\"", "of an edge");
  legend(svg, {305, 22}, std::string("stroke-width=\"3\" stroke=\"") + kColour[0] + "\"", "of a vertex");
  legend(svg, {430, 22}, "stroke-width=\"1.2\" stroke-dasharray=\"3 2\" stroke=\"#333\"",
         "below another patch");
  legend(svg, {600, 22}, "stroke=\"#888\" stroke-dasharray=\"4 3\"", "tool: a ball of 6 mm, and its centre");
  return svg.write(file);
}

}  // namespace tiltfeed::pictures
