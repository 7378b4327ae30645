// Which directions of the tool axis a pass through a hollow allows, and which are chosen.

#include <algorithm>
#include <array>
#include <cmath>

#include "pathgen/free_axis/pass_curve.h"
#include "pathgen/free_axis/tool_axis_path.h"
#include "pathgen/free_slices/cl_slices.h"
#include "pathgen/options/axis_step.h"
#include "tests/pictures/pictures.h"
#include "tests/pictures/section_part.h"

namespace tiltfeed::pictures {
using namespace pathgen;
namespace {

constexpr double kTolerance = 0.01;              // mm
constexpr double kRadius = 2.0;                  // of the ball, mm
constexpr double kMost = 90.0, kLeanStep = 1.0;  // degrees
constexpr double kToolAt = 17.5;
constexpr double kBetweenTools = 5.0;  // mm of the pass
constexpr const char* kAdmitted = "#bbdfc5";
constexpr const char* kChosen = "#1d4ed8";
constexpr const char* kWished = "#c2410c";

const Line& hollow() {
  static const Line outline{{0, 16}, {8, 16}, {11, 3}, {16, 0}, {28, 0}, {33, 3}, {37, 20}, {46, 20}};
  return outline;
}

PlanOptions options() {
  PlanOptions o;
  o.name = "hollow";
  o.cutter = {.diameter = 2 * kRadius, .length = 90, .shank_length = 18, .holder = {{12, 18, 12}}};
  o.axis.mode = AxisMode::kFree;
  o.free.plane_normals = {{0, 1, 0}};
  o.free.smoothing = 2.0;
  o.free.max_turn = Angle::from_degrees(15);
  o.pattern.side_step = 8.0;
  o.tolerance = kTolerance;
  o.containment.first = {1.0, 45.0}, o.containment.second = {-9.0, 9.0}, o.containment.height = {1.0, 60.0};
  return o;
}

/// In the section, from z towards x.
Vec3 axis_of(double degrees) {
  const double a = Angle::from_degrees(degrees).radians();
  return {std::sin(a), 0.0, std::cos(a)};
}
double lean_of(Vec3 axis) { return Angle::from_radians(std::atan2(axis.x, axis.z)).degrees(); }

struct Asked {
  const ClChain& chain;
  const PassCurve& curve;
  const Admissibility& admissible;
  const ToolAxisPass& pass;
};

/// Bands of admissible leans at a place, degrees.
std::vector<std::array<double, 2>> bands(const Admissibility& admissible, const ClPoint& point) {
  DirectionQuery query;
  std::vector<std::array<double, 2>> found;
  bool open = false;
  for (double lean = -kMost; lean <= kMost; lean += kLeanStep) {
    const Vec3 axis = axis_of(lean);
    const bool admitted =
        admissible.within_limits(point.normal, axis) && admissible.admits(point, axis, query);
    if (admitted && !open) found.push_back({lean - kLeanStep / 2, 0});
    if (admitted) found.back()[1] = lean + kLeanStep / 2;
    open = admitted;
  }
  return found;
}

/// How far along the pass a place of it is, mm.
double way_of(const PassCurve& curve, Point<Part> centre) {
  double best = 0.0, least = 1e9;
  for (double way = 0.0; way <= curve.length(); way += 0.02)
    if (const double off = distance(curve.at(way).centre, centre); off < least) least = off, best = way;
  return best;
}

/// Half of the tool's outline, mirrored, at a pose.
void tool(Svg& svg, const Plot& plot, const ToolAxisPoint& at, const Cutter& cutter) {
  const Vec3 axis = axis_of(lean_of(at.axis)), side{axis.z, 0.0, -axis.x};
  const double r = cutter.radius(), above = cutter.shank_length - r;
  Line half{{r, 0}, {r, above}};
  double top = above;
  for (const HolderStep& step : cutter.holder) {
    half.push_back({step.lower_diameter / 2, top});
    half.push_back({step.upper_diameter / 2, top += step.length});
  }
  Line outline;
  const auto add = [&](double across, double up) {
    const Point<Part> p = at.point.centre + side * across + axis * up;
    outline.push_back({p.x, p.z});
  };
  for (int i = -90; i <= 0; i += 15) add(r * std::cos(i * kPi / 180), r * std::sin(i * kPi / 180));
  for (const At p : half) add(p.x, p.y);
  for (auto p = half.rbegin(); p != half.rend(); ++p) add(-p->x, p->y);
  for (int i = 180; i <= 270; i += 15) add(r * std::cos(i * kPi / 180), r * std::sin(i * kPi / 180));
  svg.path(plot.at(outline), "fill=\"#888\" fill-opacity=\"0.15\" stroke=\"#777\"", true);
}

void section(Svg& svg, const Asked& asked, const Cutter& cutter) {
  const Plot plot = even_plot({45, 64}, {-2, -4}, {52, 40}, 8.0);
  plot.grid(svg, {10, 10}, "x, mm", "z, mm");
  Line solid = hollow();
  solid.push_back({solid.back().x, kBottom});
  solid.push_back({solid.front().x, kBottom});
  svg.path(plot.at(solid), "fill=\"#d0d4da\" stroke=\"#555\"", true);
  Line centres;
  for (const ClPoint& p : asked.chain.points) centres.push_back({p.centre.x, p.centre.z});
  svg.path(plot.at(centres), "stroke=\"#333\" stroke-dasharray=\"3 2\"");
  const ToolAxisRun& first = asked.pass.runs.front();
  const auto shown = std::find_if(first.begin(), first.end(), [&](const ToolAxisPoint& at) {
    return way_of(asked.curve, at.point.centre) >= kToolAt;
  });
  if (shown != first.end()) tool(svg, plot, *shown, cutter);
  double next = kBetweenTools / 2;
  for (const ToolAxisRun& run : asked.pass.runs)
    for (const ToolAxisPoint& at : run) {
      const double way = way_of(asked.curve, at.point.centre);
      if (way < next) continue;
      next += kBetweenTools;
      const At c{at.point.centre.x, at.point.centre.z};
      for (const auto& [from, to] : bands(asked.admissible, at.point)) {
        Line fan{c};
        for (double lean = from; lean < to + 3.0; lean += 3.0) {
          const Vec3 axis = axis_of(std::min(lean, to));
          fan.push_back({c.x + 3.2 * axis.x, c.y + 3.2 * axis.z});
        }
        svg.path(plot.at(fan), std::string("fill=\"") + kAdmitted + "\" stroke=\"#5b9b6b\"", true);
      }
      const Vec3 wish = asked.curve.wished(way) * 4.2, axis = at.axis * 5.0;
      svg.line(plot.at(c), plot.at(At{c.x + wish.x, c.y + wish.z}),
               std::string("stroke-width=\"1.5\" stroke=\"") + kWished + "\"");
      svg.line(plot.at(c), plot.at(At{c.x + axis.x, c.y + axis.z}),
               std::string("stroke-width=\"2.5\" stroke=\"") + kChosen + "\"");
    }
}

void chart(Svg& svg, const Asked& asked) {
  const Plot plot{{540, 64}, 340, 352, {0, -kMost}, {std::ceil(asked.curve.length() / 5) * 5, kMost}};
  const double width = 0.6;
  for (double way = width / 2; way < asked.curve.length(); way += width)
    for (const auto& [from, to] : bands(asked.admissible, asked.curve.at(way))) {
      const At corner = plot.at({way - width / 2, to});
      svg.box(corner, width * plot.per_x() + 0.3, plot.at({0, from}).y - corner.y,
              std::string("fill=\"") + kAdmitted + "\"");
    }
  plot.grid(svg, {10, 30}, "way along the pass, mm", "lean in the section, degrees");
  Line wished;
  for (double way = 0.0; way <= asked.curve.length(); way += 0.25)
    wished.push_back({way, lean_of(asked.curve.wished(way))});
  svg.path(plot.at(wished), std::string("stroke-width=\"1.5\" stroke=\"") + kWished + "\"");
  for (const ToolAxisRun& run : asked.pass.runs) {
    Line chosen;
    for (const ToolAxisPoint& at : run)
      chosen.push_back({way_of(asked.curve, at.point.centre), lean_of(at.axis)});
    svg.path(plot.at(chosen), std::string("stroke-width=\"2.5\" stroke=\"") + kChosen + "\"");
  }
}

}  // namespace

Result<void> draw_directions(const std::string& file) {
  const auto part = section_part(hollow(), false);
  if (!part) return tl::unexpected(part.error());
  const PlanOptions o = options();
  const FacetBvh tree(part->mesh);
  const ToleranceBudget budget(o.tolerance);
  const auto slices = slice_cl_surface(*part, tree, o, budget, [](double) { return true; });
  const auto slice = std::min_element(slices.begin(), slices.end(), [](const ClSlice& a, const ClSlice& b) {
    return std::abs(a.height) < std::abs(b.height);
  });
  if (slice == slices.end()) return fail(Code::kMesh, "no plane cuts the hollow");
  ClChain chain = slice->chain;
  if (chain.points.front().centre.x > chain.points.back().centre.x)
    std::reverse(chain.points.begin(), chain.points.end());
  const SweptTool swept(tree, o, budget.flank());
  const DirectionGrid grid(Admissibility::kAdmissibleLevel + 1);
  const Admissibility admissible(swept, grid, o.up, Angle::from_degrees(kMost));
  const ToolAxisOptions how{o.free, o.tolerance, largest_axis_step(o), 0.0, reference_height(o.cutter)};
  const ToolAxisPass pass = choose_tool_axes(chain, admissible, how);
  const PassCurve curve(chain, o.free);
  if (pass.runs.empty()) return fail(Code::kUnreachable, "no direction is admissible in the hollow");

  Svg svg(900, 465, "Admissible, wished and chosen tool axes along a pass through a hollow");
  const Asked asked{chain, curve, admissible, pass};
  section(svg, asked, o.cutter);
  chart(svg, asked);
  svg.box({45, 13}, 24, 12, std::string("fill=\"") + kAdmitted + "\"");
  svg.text({75, 24}, "admissible in the section");
  legend(svg, {240, 24}, std::string("stroke-width=\"1.5\" stroke=\"") + kWished + "\"",
         "wished: the surface's normal");
  legend(svg, {455, 24}, std::string("stroke-width=\"2.5\" stroke=\"") + kChosen + "\"", "chosen");
  legend(svg, {550, 24}, "stroke=\"#333\" stroke-dasharray=\"3 2\"", "way of the ball's centre");
  svg.box({740, 13}, 24, 12, "fill=\"#888\" fill-opacity=\"0.15\" stroke=\"#777\"");
  svg.text({770, 24}, "tool with holder");
  return svg.write(file);
}

}  // namespace tiltfeed::pictures
