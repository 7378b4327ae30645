#include "tests/pictures/section_part.h"

#include <utility>

#include "pathgen/mesh/mesh_check.h"

namespace tiltfeed::pictures {
using namespace pathgen;
namespace {

constexpr double kRows[] = {-14.0, -6.0, 6.0, 14.0};  // y of the grid's lines

const Line& base() {
  static const Line outline{{0, 0},    {kPeakFrom, 0}, {kPeakTo, 0}, {24, 0},   {29, 6},  {37, 6},
                            {37.6, 1}, {44, 1},        {50, 7},      {56, 2.5}, {62, 2.5}};
  return outline;
}

struct Soup {
  Stl stl;
  void facet(Point<Part> a, Point<Part> b, Point<Part> c) { stl.facets.push_back({a, b, c}); }
  void quad(Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
    facet(a, b, c);
    facet(a, c, d);
  }
};

}  // namespace

Result<CheckedMesh> section_part(const Line& outline, bool with_peak) {
  Soup soup;
  const auto top = [](At p, double y) { return Point<Part>{p.x, y, p.y}; };
  const auto foot = [](At p, double y) { return Point<Part>{p.x, y, kBottom}; };
  for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
    const At p = outline[i], q = outline[i + 1];
    for (int row = 0; row < 3; ++row) {
      const double y0 = kRows[row], y1 = kRows[row + 1];
      soup.quad(foot(p, y0), foot(p, y1), foot(q, y1), foot(q, y0));
      if (with_peak && row == 1 && p.x == kPeakFrom) {
        const Point<Part> tip{(p.x + q.x) / 2.0, 0.0, kPeakHeight};
        soup.facet(top(p, y0), top(q, y0), tip);
        soup.facet(top(q, y0), top(q, y1), tip);
        soup.facet(top(q, y1), top(p, y1), tip);
        soup.facet(top(p, y1), top(p, y0), tip);
      } else {
        soup.quad(top(p, y0), top(q, y0), top(q, y1), top(p, y1));
      }
    }
    soup.quad(foot(p, kRows[0]), foot(q, kRows[0]), top(q, kRows[0]), top(p, kRows[0]));
    soup.quad(foot(q, kRows[3]), foot(p, kRows[3]), top(p, kRows[3]), top(q, kRows[3]));
  }
  for (int row = 0; row < 3; ++row) {
    const At p = outline.front(), q = outline.back();
    soup.quad(foot(p, kRows[row + 1]), foot(p, kRows[row]), top(p, kRows[row]), top(p, kRows[row + 1]));
    soup.quad(foot(q, kRows[row]), foot(q, kRows[row + 1]), top(q, kRows[row + 1]), top(q, kRows[row]));
  }
  auto checked = check_mesh(soup.stl);
  if (checked && !checked->defects.empty())
    return fail(Code::kMesh, "the part of the pictures is not closed: " + checked->defects[0].first);
  return checked;
}

Result<CheckedMesh> section_part() { return section_part(base(), true); }

Line section_outline() {
  Line outline = base();
  outline.insert(outline.begin() + 2, {(kPeakFrom + kPeakTo) / 2.0, kPeakHeight});
  return outline;
}

Result<std::unique_ptr<SectionField>> section_field() {
  auto part = section_part();
  if (!part) return tl::unexpected(part.error());
  PlanOptions options;
  options.name = "section";
  options.cutter = {.diameter = 2 * kBall, .length = 60, .shank_length = 30};
  auto out = std::make_unique<SectionField>();
  out->part = std::move(*part);
  std::vector<std::string> warnings;
  auto field = make_field(out->part, options, warnings);
  if (!field) return tl::unexpected(field.error());
  if (!warnings.empty()) return fail(Code::kMesh, warnings.front());
  out->field = std::move(*field);
  return out;
}

Plot section_plot(Svg& svg, At corner) {
  const Plot plot = even_plot(corner, {-5, kBottom}, {67, 15}, 11.5);
  plot.grid(svg, {5, 5}, "x, mm", "z, mm");
  Line solid = section_outline();
  solid.push_back({solid.back().x, kBottom});
  solid.push_back({solid.front().x, kBottom});
  svg.path(plot.at(solid), "fill=\"#d0d4da\" stroke=\"#555\"", true);
  return plot;
}

}  // namespace tiltfeed::pictures
