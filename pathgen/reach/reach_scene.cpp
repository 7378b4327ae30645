#include "pathgen/reach/reach_scene.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pathgen/axis/direction_grid.h"
#include "pathgen/mesh/ray_scene.h"
#include "pathgen/tool/contact_line.h"

namespace tiltfeed::pathgen {

namespace {

/// Rays are of single precision and facets are chords: what starts on the surface starts this share of its
/// radius, and twice the tolerance, further in.
constexpr double kShareOff = 0.01;
/// Rays round one width of the tool.
constexpr int kRimRays = 6;
/// Directions of the free axis: 16 degrees apart, or the question's own.
constexpr int kGridLevel = 2;
/// Nearer than this to the point, line or circle the axis has no direction, mm.
constexpr double kLeastRho = 1e-6;
/// So many places a task.
constexpr std::size_t kGrain = 512;

/// A width of the tool: rays start round it at this height over the reference.
struct Rim {
  double height = 0.0, radius = 0.0;
};

std::vector<Rim> rims_of(const std::vector<ToolPiece>& pieces, double tolerance) {
  std::vector<Rim> rims;
  const auto add = [&](double height, double radius) {
    const double smaller = radius * (1.0 - kShareOff) - 2.0 * tolerance;
    if (smaller > 0.0) rims.push_back({height, smaller});
  };
  for (const ToolPiece& piece : pieces) {
    add(piece.above_reference, piece.has_cone() ? piece.flat + piece.corner * piece.taper_cos : piece.outer);
    if (piece.has_cone()) add(piece.above_reference + piece.cone_height(piece.outer), piece.outer);
  }
  return rims;
}

Point<Part> middle_of(const Box& box) { return lerp(box.min, box.max, 0.5); }

}  // namespace

struct ReachScene::Parts {
  const CheckedMesh& part;
  std::vector<ToolPiece> pieces;
  std::vector<Rim> rims;
  double tolerance, tool_top, tip, whole;  ///< mm; whole: a length that leaves the part
  std::vector<Vec3> grid;
  double steepest_cos;
  RayScene scene;

  Parts(const CheckedMesh& p, const PlanOptions& tool)
      : part(p),
        pieces(tool_pieces(tool)),
        rims(rims_of(pieces, tool.tolerance)),
        tolerance(tool.tolerance),
        tool_top(tool.cutter.shank_length),
        tip(reference_height(tool.cutter)),
        whole(2.0 * distance(p.bounds.min, p.bounds.max)),
        grid(DirectionGrid(kGridLevel).directions()),
        steepest_cos(std::cos(tool.indexed.steepest.radians())),
        scene(middle_of(p.bounds)) {
    for (const HolderStep& step : tool.cutter.holder) tool_top += step.length;
    scene.add_triangles(part.mesh, 0.0);
    scene.commit();
  }

  /// (X2) The rounded end, lifted by the tolerance, is clear of the part where it touches the place.
  bool fits(Point<Part> place, Vec3 normal) const {
    const double r = pieces.front().corner;
    return r <= 0.0 || !scene.within(place + normal * (r + tolerance), r * (1.0 - 1e-4));
  }

  ReachPlace facet(std::uint32_t i) const {
    const auto& f = part.mesh.facets[i];
    const Point<Part> a = part.mesh.vertices[f[0]];
    const Vec3 ab = part.mesh.vertices[f[1]] - a, ac = part.mesh.vertices[f[2]] - a, twice = cross(ab, ac);
    return {a + (ab + ac) / 3.0, normalized(twice), 0.5 * length(twice), i, true};
  }

  bool clear(Point<Part> reference, Vec3 axis, double travel, Rays rays) const {
    if (scene.hits(reference, axis, travel)) return false;
    if (rays == Rays::kAxis) return true;
    const Vec3 pick = std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 u = normalized(cross(axis, pick)), v = cross(axis, u);
    for (const Rim& rim : rims)
      for (int k = 0; k < kRimRays; ++k) {
        const double turn = 2.0 * kPi * k / kRimRays;
        const Vec3 out = (u * std::cos(turn) + v * std::sin(turn)) * rim.radius;
        if (scene.hits(reference + axis * rim.height + out, axis, travel)) return false;
      }
    return true;
  }
};

namespace {

bool is_predefined(const ReachQuestion& question) {
  return question.axis.mode != AxisMode::kFree && question.axis.mode != AxisMode::kIndexed;
}

/// A question made ready.
struct Asked {
  const ReachQuestion& q;
  bool predefined;
  Deformation map;
  double tilt_cos;
  Rays rays;
  DrawnBack drawn_back;

  Asked(const ReachQuestion& question, Rays r, const Box& box)
      : q(question),
        predefined(is_predefined(question)),
        map(predefined ? question.axis : AxisFrame{}, 1.0),
        tilt_cos(std::cos(std::min(question.tilt_max.radians(), kPi))),
        rays(r),
        drawn_back(question, box) {}

  bool leans_too_far(Vec3 axis) const { return dot(axis, q.up) < tilt_cos - 1e-9; }
  /// `tip`: from the reference down.
  Reach on_machine(Point<Part> reference, Vec3 axis, double tip) const {
    if (leans_too_far(axis)) return Reach::kTilt;
    if (q.machine == nullptr) return Reach::kCut;
    const Pose pose{reference - axis * tip, axis};
    if (const auto refused = q.machine->refusal(pose)) return *refused;
    const double back = drawn_back(reference, axis);
    if (back == 0.0) return Reach::kCut;
    return q.machine->refusal({pose.tip + axis * back, axis}).value_or(Reach::kCut);
  }
};

}  // namespace

ReachScene::ReachScene(const CheckedMesh& part, const PlanOptions& tool)
    : parts_(std::make_unique<const Parts>(part, tool)) {}
ReachScene::~ReachScene() = default;

std::vector<ReachPlace> ReachScene::facets() const {
  std::vector<ReachPlace> places(parts_->part.mesh.facets.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, places.size(), kGrain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      places[i] = parts_->facet(static_cast<std::uint32_t>(i));
      places[i].fits = parts_->fits(places[i].place, places[i].normal);
    }
  });
  return places;
}

std::vector<ReachPlace> ReachScene::sample(std::size_t count) const {
  const Mesh& mesh = parts_->part.mesh;
  double whole = 0.0;
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) whole += parts_->facet(i).area;
  std::vector<ReachPlace> places;
  const double share = whole / static_cast<double>(count);
  double sum = 0.0;
  for (std::uint32_t i = 0; i < mesh.facets.size(); ++i) {
    const ReachPlace facet = parts_->facet(i);
    sum += facet.area;
    const auto& f = mesh.facets[i];
    // A large facet stands for several: spread over it by the golden ratio.
    const std::size_t first = places.size();
    for (; (static_cast<double>(places.size()) + 0.5) * share <= sum && places.size() < count;) {
      ReachPlace place = facet;
      place.area = share;
      if (facet.area > 1.5 * share) {
        const auto k = static_cast<double>(places.size() - first);
        double u = std::fmod(0.5 + 0.7548776662466927 * k, 1.0),
               v = std::fmod(0.5 + 0.5698402909980532 * k, 1.0);
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        const Point<Part> a = mesh.vertices[f[0]];
        place.place = a + (mesh.vertices[f[1]] - a) * u + (mesh.vertices[f[2]] - a) * v;
      }
      places.push_back(place);
    }
  }
  tbb::parallel_for(std::size_t{0}, places.size(),
                    [&](std::size_t i) { places[i].fits = parts_->fits(places[i].place, places[i].normal); });
  return places;
}

namespace {

/// (X1) In one axis field.
template <class Parts>
Reach in_field(const Parts& parts, const Asked& asked, const ReachPlace& place) {
  const ToolPiece& piece = parts.pieces.front();
  AxisLine line{place.place + place.normal * piece.corner, {}};  // a ball's centre does not ask for the axis
  if (!piece.is_ball_at_reference()) line = contact_line(piece, asked.map, place.place, place.normal);
  const Deformation::Aim aim = asked.map.aim(line.base);
  if (std::min(aim.away.rho, aim.away.r) < kLeastRho) return Reach::kBlocked;
  line.axis = aim.axis;
  if (dot(place.normal, line.axis) < -kWallLean) return Reach::kAway;
  if (!place.fits) return Reach::kNarrow;
  double travel = parts.whole;
  if (asked.map.s() < 0.0) travel = std::min(travel, aim.away.rho + parts.tool_top);
  if (!parts.clear(line.base, line.axis, travel, asked.rays)) return Reach::kBlocked;
  return asked.on_machine(line.base, line.axis, parts.tip);
}

/// (X3) With any of several directions; `last` served the place before.
template <class Parts>
Reach in_any(const Parts& parts, const Asked& asked, const ReachPlace& place, std::size_t& last) {
  if (!place.fits) return Reach::kNarrow;
  const bool free = asked.q.axis.mode == AxisMode::kFree;
  const std::vector<Vec3>& directions = asked.q.directions.empty() ? parts.grid : asked.q.directions;
  Reach best = free ? Reach::kBlocked : Reach::kAway;
  const auto serves = [&](Vec3 axis) {
    if (dot(axis, place.normal) < parts.steepest_cos) return false;
    // A direction that the machine does not reach is looked along only to tell why.
    const bool leans = asked.leans_too_far(axis);
    if (leans && best == Reach::kTilt) return false;
    const Point<Part> reference = contact_reference(parts.pieces.front(), axis, place.place, place.normal);
    Reach found = leans ? Reach::kTilt : asked.on_machine(reference, axis, parts.tip);
    if (found != Reach::kCut && static_cast<int>(found) <= static_cast<int>(best) && best != Reach::kAway)
      return false;
    if (!parts.clear(reference, axis, parts.whole, asked.rays)) found = Reach::kBlocked;
    // The later in the list the nearer to being cut.
    if (found == Reach::kCut || static_cast<int>(found) > static_cast<int>(best)) best = found;
    return found == Reach::kCut;
  };
  if (free && serves(place.normal)) return Reach::kCut;
  if (last < directions.size() && serves(directions[last])) return Reach::kCut;
  for (std::size_t d = 0; d < directions.size(); ++d)
    if (d != last && serves(directions[d])) {
      last = d;
      return Reach::kCut;
    }
  return best;
}

}  // namespace

DrawnBack::DrawnBack(const ReachQuestion& question, const Box& box) : question_(question) {
  if (!question.clearance) return;
  if (is_predefined(question)) map_.emplace(question.axis, 1.0);
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    corners_[i] = {i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                   i & 4 ? box.max.z : box.min.z};
    if (!map_) continue;
    const double z = map_->flatten(corners_[i]).z;
    top_ = i == 0 ? z : std::max(top_, z);
  }
}

double DrawnBack::operator()(Point<Part> reference, Vec3 axis) const {
  if (!question_.clearance || (map_ && map_->s() < 0.0)) return 0.0;
  if (map_) return std::max(0.0, top_ - map_->flatten(reference).z) + *question_.clearance;
  double most = 0.0;
  for (const Point<Part> corner : corners_) most = std::max(most, dot(corner - reference, axis));
  return most + *question_.clearance;
}

ReachMap ReachScene::ask(const ReachQuestion& question, std::span<const ReachPlace> places, Rays rays) const {
  const Asked asked(question, rays, parts_->part.bounds);
  ReachMap map;
  map.places.resize(places.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, places.size(), kGrain), [&](const auto& range) {
    std::size_t last = 0;
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      map.places[i] =
          asked.predefined ? in_field(*parts_, asked, places[i]) : in_any(*parts_, asked, places[i], last);
  });
  for (std::size_t i = 0; i < places.size(); ++i)
    map.area[static_cast<std::size_t>(map.places[i])] += places[i].area;
  return map;
}

}  // namespace tiltfeed::pathgen
