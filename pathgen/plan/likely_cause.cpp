#include "pathgen/plan/likely_cause.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "kinematics/basics/units.h"
#include "pathgen/axis/deformation.h"
#include "pathgen/mesh/ray_scene.h"
#include "pathgen/mesh/winding_number.h"
#include "pathgen/pattern/region.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

namespace {

constexpr std::size_t kPlaces = 24;
/// Of a circle: a larger angle without any corner of the part is no part of it.
constexpr double kWidestGap = kPi / 2.0;
constexpr double kFewer = 0.1;         ///< share of the other sense's area
constexpr double kNoRoom = 0.1;        ///< share of the cutter's radius
constexpr double kLeastFacing = 0.02;  ///< share of the part's area that the other sense must face
constexpr int kHalvings = 30;
constexpr std::size_t kTouched = 512;
/// Sine: what leans over the axis by less is a wall.
constexpr double kFacing = 0.26;

std::string per_cent(double share) { return number_text(std::round(1000.0 * share) / 10.0) + " %"; }

const char* name_of(AxisMode mode) {
  if (mode == AxisMode::kPoint) return "axis point";
  return mode == AxisMode::kLine ? "axis line" : "axis circle";
}

/// Evenly along the part, each in the middle of its share.
std::vector<Point<Part>> places_of(const AxisFrame& axis, const Mesh& mesh) {
  if (axis.mode == AxisMode::kPoint) return {axis.origin};
  std::vector<double> at;
  for (Point<Part> v : mesh.vertices) {
    const Vec3 p = v - axis.origin;
    at.push_back(axis.mode == AxisMode::kLine ? dot(p, axis.t) : std::atan2(dot(p, axis.t), dot(p, axis.n)));
  }
  std::sort(at.begin(), at.end());
  double from = at.front(), to = at.back();
  if (axis.mode == AxisMode::kCircle) {
    double widest = from + 2.0 * kPi - to;
    for (std::size_t i = 1; i < at.size(); ++i)
      if (at[i] - at[i - 1] > widest) widest = at[i] - at[i - 1], from = at[i], to = at[i - 1] + 2.0 * kPi;
    if (widest < kWidestGap) to = from + 2.0 * kPi;
  }
  std::vector<Point<Part>> places;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const double a = from + (to - from) * (static_cast<double>(i) + 0.5) / kPlaces;
    places.push_back(axis.mode == AxisMode::kLine
                         ? axis.origin + axis.t * a
                         : axis.origin + (axis.n * std::cos(a) + axis.t * std::sin(a)) * axis.circle_radius);
  }
  return places;
}

/// Shares of the part's area that face the tool within the tilt limit.
struct Facing {
  double outward = 0.0, inward = 0.0;
};

Facing facing(const Mesh& mesh, const PlanOptions& options) {
  AxisFrame outward = options.axis;
  outward.sense = Sense::kOutward;
  const Deformation map(outward, 1.0);
  const double least = std::cos(options.tilt_max.radians());
  Facing sum;
  double all = 0.0;
  for (const auto& f : mesh.facets) {
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const Vec3 normal = cross(b - a, c - a);
    const Deformation::Aim aim = map.aim(lerp(lerp(a, b, 0.5), c, 1.0 / 3.0));
    all += length(normal);
    if (aim.away.rho <= 0.0) continue;
    const double up = dot(aim.axis, options.up), out = dot(normal, aim.axis);
    if (out > 0.0 && up >= least) sum.outward += length(normal);
    if (out < 0.0 && -up >= least) sum.inward += length(normal);
  }
  return {sum.outward / all, sum.inward / all};
}

/// How far the part is from p, mm, if less than `limit`.
double room(const RayScene& scene, Point<Part> p, double limit) {
  if (!scene.within(p, limit)) return limit;
  double low = 0.0, high = limit;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (scene.within(p, middle) ? high : low) = middle;
  }
  return high;
}

/// Places on the part that face the tool, within tilt limit and containment, where a ball of `radius`
/// touches.
struct Touched {
  Point<Part> place;
  Vec3 normal;
};

std::vector<Touched> touched_places(const Mesh& mesh, const PlanOptions& options, double radius) {
  const Deformation map(options.axis, 1.0);
  const Region region(options.containment, map);
  const double least = std::cos(options.tilt_max.radians());
  std::vector<Touched> all, some;
  for (const auto& f : mesh.facets) {
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const Vec3 across = cross(b - a, c - a);
    if (!(length(across) > 0.0)) continue;
    const Touched one{lerp(lerp(a, b, 0.5), c, 1.0 / 3.0), normalized(across)};
    const Point<Part> centre = one.place + one.normal * radius;
    const Vec3 axis = map.axis_at(centre);
    if (dot(one.normal, axis) < kFacing || dot(axis, options.up) < least) continue;
    if (region.contains(map.flatten(centre))) all.push_back(one);
  }
  const std::size_t count = std::min(all.size(), kTouched);
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

/// The largest ball up to `limit` that touches the place and nothing else of the part by more than `slack`.
double ball_at(const RayScene& scene, const Touched& at, double limit, double slack) {
  const auto fits = [&](double radius) {
    return radius <= slack || !scene.within(at.place + at.normal * radius, radius - slack);
  };
  if (fits(limit)) return limit;
  double low = 0.0, high = limit;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (fits(middle) ? low : high) = middle;
  }
  return low;
}

/// Where the cutter fits nowhere: what does. Nothing where it fits somewhere, or where no place is asked.
std::string fits_nowhere(const Mesh& mesh, const PlanOptions& options, const RayScene& scene) {
  const ToolPiece piece = tool_pieces(options).front();
  const double radius = piece.has_cone() ? piece.corner : piece.outer;
  const std::vector<Touched> places = touched_places(mesh, options, radius);
  double widest = 0.0;
  for (const Touched& at : places) {
    widest = std::max(widest, ball_at(scene, at, radius, options.tolerance));
    if (widest >= radius) return "";
  }
  if (places.empty()) return "";
  return "the cutter is too big for every hollow: with its stock it has a radius of " + number_text(radius) +
         " mm, and at none of " + std::to_string(places.size()) +
         " places that face the tool in the containment does the part leave more than " +
         number_text(std::floor(1000.0 * widest) / 1000.0) + " mm; use a cutter.diameter_mm below " +
         number_text(std::floor(1000.0 * std::max(0.0, options.cutter.diameter - 2.0 * (radius - widest))) /
                     1000.0) +
         ", or widen the containment";
}

std::vector<char> inside_of(const Mesh& mesh, const std::vector<Point<Part>>& places) {
  std::vector<char> inside(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(),
                    [&](std::size_t i) { inside[i] = winding_number(mesh, places[i]) > 0.5; });
  return inside;
}

/// Outward work whose feature lies neither in the part nor under it; inward work whose feature is not all in
/// the hollow. `inside`: of so many places in all.
std::string through_surface(const PlanOptions& options, std::size_t inside, std::size_t all) {
  if (all < 2) return "";
  const bool inward = options.axis.sense == Sense::kInward;
  if (inward ? inside == 0 : 4 * inside < all || 4 * inside > 3 * all) return "";
  return std::string("the ") + name_of(options.axis.mode) + " runs through the part's surface: of " +
         std::to_string(all) + " places along the part " + std::to_string(inside) +
         " lie in the material and the others outside, and " +
         (inward ? "inside work wants all of them in the hollow that is cut; move axis.origin_mm, turn "
                   "axis.t, or "
                   "leave out by the containment where it enters the material"
                 : "outward work wants all on one side of what is cut; move axis.origin_mm, or turn axis.t");
}

std::string wrong_sense(const PlanOptions& options, double here, double other) {
  const bool inward = options.axis.sense == Sense::kInward;
  return "axis.sense looks wrong: within setup.tilt_max_deg " + per_cent(here) +
         " of the part's area faces a tool that points " + (inward ? "inward" : "outward") + ", " +
         per_cent(other) + " one that points " + (inward ? "outward" : "inward") +
         "; use axis.sense: " + (inward ? "outward" : "inward");
}

std::string in_material(const PlanOptions& options, std::size_t inside, std::size_t all,
                        const Facing& shares) {
  std::string text = std::string("the ") + name_of(options.axis.mode) + " lies in the material";
  if (all > 1)
    text += " at " + std::to_string(inside) + " of " + std::to_string(all) + " places along the part";
  text += ", and inside work (axis.sense: inward) starts from it; ";
  if (shares.outward > shares.inward)
    text += per_cent(shares.outward) + " of the part's area faces a tool that points outward, " +
            per_cent(shares.inward) + " one that points inward: use axis.sense: outward, or ";
  return text + "move axis.origin_mm into the hollow that is to be cut";
}

std::string too_big(const PlanOptions& options, double cutter, double room) {
  return std::string("the cutter is too big for the hollow: with its stock it has a radius of ") +
         number_text(cutter) + " mm, and the part leaves at most " + number_text(room) + " mm round the " +
         name_of(options.axis.mode) + "; use a cutter.diameter_mm below " +
         number_text(options.cutter.diameter - 2.0 * (cutter - room)) +
         ", or move axis.origin_mm to the middle of the hollow";
}

}  // namespace

std::string likely_cause(const CheckedMesh& part, const PlanOptions& options) {
  const AxisMode mode = options.axis.mode;
  const bool fixed = mode == AxisMode::kFixed;
  if (!fixed && mode != AxisMode::kPoint && mode != AxisMode::kLine && mode != AxisMode::kCircle) return "";
  if (part.sides != Sides::kOutward) return "";
  RayScene scene(options.axis.origin);
  scene.add_triangles(part.mesh, 0.0);
  scene.commit();
  if (fixed) return fits_nowhere(part.mesh, options, scene);
  const Facing shares = facing(part.mesh, options);
  const bool inward = options.axis.sense == Sense::kInward;
  const double here = inward ? shares.inward : shares.outward,
               other = inward ? shares.outward : shares.inward;
  const std::vector<Point<Part>> places = places_of(options.axis, part.mesh);
  const std::vector<char> inside = inside_of(part.mesh, places);
  const auto count = static_cast<std::size_t>(std::count(inside.begin(), inside.end(), 1));
  if (inward && 2 * count >= places.size()) return in_material(options, count, places.size(), shares);
  if (inward) {
    const double cutter = tool_pieces(options).front().outer;
    double widest = 0.0;
    for (std::size_t i = 0; i < places.size(); ++i)
      if (!inside[i]) widest = std::max(widest, room(scene, places[i], cutter));
    // A feature that enters the material and has next to no room outside lies in no hollow.
    if (count > 0 && widest < kNoRoom * cutter && other > here) return wrong_sense(options, here, other);
    if (widest < cutter) return too_big(options, cutter, widest);
  }
  if (other >= kLeastFacing && here < kFewer * other) return wrong_sense(options, here, other);
  const std::string nowhere = fits_nowhere(part.mesh, options, scene);
  if (!nowhere.empty()) return nowhere;
  return through_surface(options, count, places.size());
}

Error with_cause(Error error, const CheckedMesh& part, const PlanOptions& options) {
  if (error.code != Code::kUnreachable && error.code != Code::kLimit && error.code != Code::kGouge)
    return error;
  const std::string cause = likely_cause(part, options);
  if (!cause.empty()) error.message = cause + ". It showed first so: " + error.message;
  return error;
}

}  // namespace tiltfeed::pathgen
