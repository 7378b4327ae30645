#include "pathgen/plan/rest_material.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "pathgen/options/side_step.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/plan/between_passes.h"
#include "pathgen/tool/contact_line.h"

namespace tiltfeed::pathgen {

namespace {

/// Neither along nor across a facet is cut into more pieces.
constexpr double kMostPieces = 32.0;
constexpr std::size_t kFacetsPerTask = 16;  ///< a large one takes as long as a thousand small ones
/// Share of the tool's radius: a wall is not looked at again where the tool stays further off.
constexpr double kNear = 0.25;
/// So often the tool steps aside for what it meets.
constexpr int kSidesteps = 4;
/// Facets that lean over by less (sine) stand beside what the envelope breaks off at.
constexpr double kSteep = 0.1;
/// Share of the tool's radius: less than that a path may leave of a wall on which it was.
constexpr double kLeftOfWall = 0.25;
/// What leans over by less (sine) than 15 degrees rows do not follow: walls are z_level's.
constexpr double kSteepest = 0.26;

/// Where the tool stands on the envelope.
struct Stand {
  Point<Part> centre;  ///< of the ring
  Vec3 axis;
};

/// Of the place from the tool that stands there, mm.
double gap(const ToolPiece& piece, Point<Part> place, const Stand& at) {
  const Vec3 w = place - at.centre;
  const double h = dot(w, at.axis);
  return distance_to_piece(piece, length(w - at.axis * h), h);
}

/// A place that the tool reaches, of which the passes leave more than the limit.
struct OverLimit {
  double left = 0.0;   ///< mm
  double share = 0.0;  ///< of the facet
  Point<Part> place;
  EnvelopePoint stand;  ///< of the tool that reaches it
};

/// In shares of the facet's area; `all` is their sum.
struct FacetVerdict {
  std::array<double, kRestReasons> uncut{};
  std::vector<std::pair<std::uint32_t, double>> fixtures;  ///< the body that keeps the tool off, each piece's
  double facing = 0.0, all = 0.0;
  std::vector<OverLimit> over;
  double most = 0.0;   ///< that the passes leave of the others, mm
  Point<Part> place;   ///< there
  double walls = 0.0;  ///< of what is steeper: share times mm that are left where that is over the limit
};

/// A facet in pieces no larger than the cutter's radius, by their middles and shares of its area: rows along
/// the shortest side, which a needle has one piece in.
struct Pieces {
  Point<Part> tip;           ///< the corner between the longer sides
  Vec3 normal, first, last;  ///< the longer sides, from the tip
  double size;

  Pieces(const Mesh& mesh, std::uint32_t facet, const ToolPiece& tool, const PlanOptions& options)
      : size(std::max(tool.outer, options.tolerance)) {
    const Facet& f = mesh.facets[facet];
    std::array<Point<Part>, 3> v{mesh.vertices[f[0]], mesh.vertices[f[1]], mesh.vertices[f[2]]};
    normal = normalized(cross(v[1] - v[0], v[2] - v[0]));
    const std::array<double, 3> opposite{distance(v[1], v[2]), distance(v[2], v[0]), distance(v[0], v[1])};
    std::rotate(v.begin(),
                v.begin() + (std::min_element(opposite.begin(), opposite.end()) - opposite.begin()), v.end());
    tip = v[0], first = v[1] - v[0], last = v[2] - v[0];
  }
  /// Calls visit(place, share).
  template <class Visit>
  void each(const Visit& visit) const {
    const double rows = pieces_of(std::max(length(first), length(last))), width = length(last - first);
    for (double i = 0.0; i < rows; ++i) {
      const double weight = 2.0 * i + 1.0, middle = (6.0 * i * (i + 1.0) + 2.0) / (3.0 * weight * rows);
      const double columns = pieces_of(width * (i + 1.0) / rows);
      for (double j = 0.0; j < columns; ++j)
        visit(tip + (first + (last - first) * ((j + 0.5) / columns)) * middle,
              weight / (rows * rows * columns));
    }
  }

 private:
  double pieces_of(double way) const { return std::clamp(std::ceil(way / size), 1.0, kMostPieces); }
};

class Judge {
 public:
  Judge(const ClField& field, const HullBvh& tree, const PlanOptions& options,
        const EnvelopeOptions& envelope, const CuttingMoves& moves, double limit, const HeldUpright& held)
      : field_(field),
        options_(options),
        moves_(moves),
        limit_(limit),
        held_(held),
        rules_(options, field),
        piece_(field.surface.pieces().front()),
        envelope_(field.surface, field.deformation, field.index, envelope) {
    envelope_.look_up_in(tree);
  }

  FacetVerdict facet(std::uint32_t i) {
    const Pieces pieces(field_.surface.mesh(), i, piece_, options_);
    FacetVerdict verdict;
    pieces.each([&](Point<Part> place, double share) {
      verdict.all += share;
      const std::optional<std::optional<RestReason>> faces = judge(i, place, share, pieces.normal, verdict);
      if (!faces) return;
      verdict.facing += share;
      if (*faces) verdict.uncut[static_cast<std::size_t>(**faces)] += share;
    });
    return verdict;
  }

 private:
  Stand stand(const EnvelopePoint& at) const {
    return {at.centre + at.axis * piece_.above_reference, at.axis};
  }

  /// (U3) Where the tool stands in contact, of the part; nothing on the cone.
  std::optional<Point<Part>> contact(const EnvelopePoint& at) const {
    const double along = dot(at.normal, at.axis);
    const ToolPiece& met = field_.surface.piece(at.patch);
    if (met.part != ToolPart::kCutter || met.at_fixtures || along < piece_.taper_sin) return std::nullopt;
    const Vec3 lateral = at.normal - at.axis * along;
    const double across = length(lateral);
    if (piece_.flat > 0.0 && across < kSteep) return std::nullopt;
    const Vec3 out = across > 0.0 ? lateral * (piece_.flat / across) : Vec3{};
    return stand(at).centre - at.normal * piece_.corner - out;
  }

  /// (U3) A tool that does not get to where it touches the place with the normal n may get to where it does
  /// so beside that: it goes there from what it meets, as far as it has leeway.
  bool touched_from_beside(Point<Part> place, Vec3 n, const AxisLine& line, EnvelopePoint met) {
    const double leeway =
        std::sqrt((2.0 * piece_.corner + options_.tolerance) * options_.tolerance) + options_.tolerance;
    const Point<Part> middle = line.base + line.axis * piece_.above_reference;
    Point<Part> centre = middle;
    for (int k = 0; k < kSidesteps; ++k) {
      const std::optional<Point<Part>> at = contact(met);
      if (!at) return false;
      const double depth = -gap(piece_, *at, {centre, line.axis});
      if (depth > leeway) return false;
      const Vec3 away = normalized(centre - *at), aside = away - n * dot(away, n);
      const double share2 = squared_length(aside);
      if (share2 * leeway * leeway < depth * depth) return false;
      centre = centre + aside * (std::max(depth, options_.tolerance / 4.0) / share2);
      if (distance(centre, middle) > leeway) return false;
      const Point<Flat> flat = field_.deformation.flatten(centre - line.axis * piece_.above_reference);
      const auto found = envelope_.at(flat.x, flat.y);
      if (!found) return false;
      if (gap(piece_, place, stand(*found)) <= options_.tolerance) return true;
      met = *found;
    }
    return false;
  }

  /// Beside a wall the envelope breaks off: half the tolerance off it the tool goes down there.
  bool touched_off_wall(const AxisLine& line, Vec3 n, Point<Part> place) {
    const Point<Flat> flat = field_.deformation.flatten(line.base + n * (options_.tolerance / 2.0));
    const auto found = envelope_.at(flat.x, flat.y);
    return found && gap(piece_, place, stand(*found)) <= options_.tolerance;
  }

  /// Nothing where the place is turned away; else why it is uncut, if it is.
  std::optional<std::optional<RestReason>> judge(std::uint32_t facet, Point<Part> place, double share, Vec3 n,
                                                 FacetVerdict& verdict) {
    const Deformation& map = field_.deformation;
    const AxisLine line = contact_line(piece_, map, place, n);
    const double facing = dot(n, line.axis);
    if (facing < -kWallLean) return std::nullopt;
    if (options_.only_faces && !options_.only_faces->chosen[facet]) return {RestReason::kContainment};
    const Point<Flat> flat = map.flatten(line.base);
    if (!rules_.region().over(flat)) return {RestReason::kContainment};
    const auto found = envelope_.at(flat.x, flat.y);
    const RestReason by_cutter = facing < kWallLean ? RestReason::kWall : RestReason::kCutter;
    if (!found) return {by_cutter};
    const Stand at = stand(*found);
    const double off = gap(piece_, place, at);
    if (off > options_.tolerance &&
        !(facing < kSteep && off < kNear * piece_.outer && touched_off_wall(line, n, place)) &&
        !touched_from_beside(place, n, line, *found)) {
      const ToolPart part = rules_.touching(*found).part;
      if (rules_.touching(*found).at_fixtures) {
        verdict.fixtures.push_back({field_.surface.facet_of(found->patch), share});
        return {RestReason::kFixture};
      }
      return {part == ToolPart::kCutter ? by_cutter : rest_reason_of(part)};
    }
    const std::optional<RestReason> refused = rules_.refusal(*found);
    if (refused == RestReason::kFixture)
      verdict.fixtures.push_back({field_.surface.facet_of(found->patch), share});
    if (!refused && held_ && off <= options_.tolerance)
      if (const auto why = left_standing(place, share, line.base, facing, *found, verdict)) return {*why};
    if (!refused && off <= options_.tolerance) {
      if (facing >= kSteepest)
        look_between(place, share, line.base, *found, verdict);
      else
        look_at_wall(place, share, line.base, verdict);
    }
    return {refused};
  }

  /// Why the path has not been at a place that the tool, upright, is held off.
  std::optional<RestReason> left_standing(Point<Part> place, double share, Point<Part> touching,
                                          double facing, const EnvelopePoint& stand,
                                          FacetVerdict& verdict) const {
    const double allowed = facing >= kSteepest ? limit_ : std::max(limit_, kLeftOfWall * piece_.outer);
    if (moves_.left(place, touching, kEnough * limit_) <= allowed) return std::nullopt;
    const std::optional<HeldStand> held = held_(stand);
    if (!held) return std::nullopt;
    if (facing < kSteep) return RestReason::kWall;
    if (held->why == RestReason::kFixture) verdict.fixtures.push_back({held->body, share});
    return held->why;
  }

  /// What the passes leave of a place that the tool reaches.
  void look_between(Point<Part> place, double share, Point<Part> touching, const EnvelopePoint& stand,
                    FacetVerdict& verdict) const {
    const double left = moves_.left(place, touching, kEnough * limit_);
    if (left > limit_) return verdict.over.push_back({left, share, place, stand});
    if (left > verdict.most) verdict.most = left, verdict.place = place;
  }

  void look_at_wall(Point<Part> place, double share, Point<Part> touching, FacetVerdict& verdict) const {
    const double left = moves_.left(place, touching, kEnough * limit_);
    if (left > limit_) verdict.walls += share * left;
  }

  const ClField& field_;
  const PlanOptions& options_;
  const CuttingMoves& moves_;
  double limit_;
  const HeldUpright& held_;
  PointRules rules_;
  const ToolPiece& piece_;
  Envelope envelope_;
};

/// What of the pieces over the limit the tool is kept off is uncut; returns the share that is left.
double without_kept_off(FacetVerdict& verdict, const KeptOff& kept_off) {
  double over = 0.0;
  for (const OverLimit& piece : verdict.over) {
    if (kept_off && kept_off(piece.stand)) {
      verdict.uncut[static_cast<std::size_t>(RestReason::kShank)] += piece.share;
      continue;
    }
    over += piece.share;
    if (piece.left > verdict.most) verdict.most = piece.left, verdict.place = piece.place;
  }
  return over;
}

}  // namespace

RestReport find_rest_material(const ClField& field, const PlanOptions& options,
                              const EnvelopeOptions& envelope, const std::vector<Move>& path,
                              const ReportShare& report_share, const KeptOff& kept_off,
                              const HeldUpright& held) {
  const Mesh& mesh = field.surface.mesh();
  const double limit = asked_height(options) + options.tolerance;
  const CuttingMoves moves(path, field.surface.pieces().front(), reference_height(options.cutter),
                           std::max(asked_step(options), options.pattern.step_down));
  std::vector<FacetVerdict> verdicts(field.surface.part_facets());
  const HullBvh tree = field.index.tree(field.deformation);
  tbb::enumerable_thread_specific<Judge> judges(
      [&] { return Judge(field, tree, options, envelope, moves, limit, held); });
  Watch watch(report_share, verdicts.size());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, verdicts.size(), kFacetsPerTask),
      [&](const auto& range) {
        Judge& judge = judges.local();
        for (std::size_t i = range.begin(); i < range.end() && watch.next(); ++i)
          verdicts[i] = judge.facet(static_cast<std::uint32_t>(i));
      },
      tbb::simple_partitioner{});
  RestReport report;
  report.between.limit = limit;
  if (options.fixtures) report.fixture_area.resize(options.fixtures->names.size(), 0.0);
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    FacetVerdict& v = verdicts[i];
    if (v.facing == 0.0) {
      ++report.away;
      continue;
    }
    const auto& f = mesh.facets[i];
    const double area =
        length(cross(mesh.vertices[f[1]] - mesh.vertices[f[0]], mesh.vertices[f[2]] - mesh.vertices[f[0]])) /
        2.0;
    BetweenPasses& between = report.between;
    between.area += area * without_kept_off(v, kept_off);
    between.walls += area * v.walls;
    const double share = std::accumulate(v.uncut.begin(), v.uncut.end(), 0.0) / v.all;
    for (const auto& [body, of] : v.fixtures) report.fixture_area[body] += area * of;
    report.facing_area += area * v.facing;
    if (v.most > between.most) between.most = v.most, between.facet = mesh.source[i], between.place = v.place;
    if (share == 0.0) continue;
    const auto why =
        static_cast<RestReason>(std::max_element(v.uncut.begin(), v.uncut.end()) - v.uncut.begin());
    (why == RestReason::kWall ? report.wall_area : report.area) += area * share;
    report.facets.push_back({mesh.source[i], why, share, static_cast<std::uint32_t>(i)});
  }
  report.between.never = report.between.most >= moves.farthest();
  report.between.most = std::max(report.between.most, kEnough * limit);
  if (!leaves_no_more(options)) report.between = {};
  std::stable_sort(report.facets.begin(), report.facets.end(),
                   [](const RestFacet& a, const RestFacet& b) { return a.facet < b.facet; });
  return report;
}

std::vector<double> facing_shares(const Mesh& mesh, const PlanOptions& options) {
  const Deformation map(options.axis, 1.0);
  const ToolPiece piece = tool_pieces(options).front();
  std::vector<double> facing(mesh.facets.size());
  tbb::parallel_for(std::size_t{0}, facing.size(), [&](std::size_t i) {
    const Pieces pieces(mesh, static_cast<std::uint32_t>(i), piece, options);
    pieces.each([&](Point<Part> place, double share) {
      const AxisLine line = contact_line(piece, map, place, pieces.normal);
      if (dot(pieces.normal, line.axis) >= -kWallLean) facing[i] += share;
    });
  });
  return facing;
}

}  // namespace tiltfeed::pathgen
