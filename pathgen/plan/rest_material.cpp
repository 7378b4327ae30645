#include "pathgen/plan/rest_material.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pathgen/options/side_step.h"
#include "pathgen/pattern/passes.h"
#include "pathgen/plan/between_passes.h"
#include "pathgen/tool/contact_line.h"

namespace tiltfeed::pathgen {

namespace {

/// A side of a facet is cut into no more pieces.
constexpr double kMostPieces = 32.0;
/// Share of the tool's radius: a wall is not looked at again where the tool stays further off.
constexpr double kNear = 0.25;
/// So often the tool steps aside for what it meets.
constexpr int kSidesteps = 4;
/// Facets that lean over by less (sine) stand beside what the envelope breaks off at.
constexpr double kSteep = 0.1;
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
  double left = 0.0;  ///< mm
  Point<Part> place;
  EnvelopePoint stand;  ///< of the tool that reaches it
};

struct FacetVerdict {
  std::array<std::uint32_t, kRestReasons> uncut{};
  std::vector<std::uint32_t> fixtures;  ///< the body that keeps the tool off a piece, for each such piece
  std::uint32_t facing = 0, pieces = 0;
  std::vector<OverLimit> over;
  double most = 0.0;  ///< that the passes leave of the others, mm
  Point<Part> place;  ///< there
};

/// A facet in pieces no larger than the cutter's radius, by their middles.
struct Pieces {
  Point<Part> corner;
  Vec3 normal, ab, ac;
  double along;  ///< of a side

  Pieces(const Mesh& mesh, std::uint32_t facet, const ToolPiece& tool, const PlanOptions& options) {
    const auto& f = mesh.facets[facet];
    const Point<Part> a = mesh.vertices[f[0]], b = mesh.vertices[f[1]], c = mesh.vertices[f[2]];
    const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
    const double size = std::max(tool.outer, options.tolerance);
    along = std::clamp(std::ceil(longest / size), 1.0, kMostPieces);
    corner = a, normal = normalized(cross(b - a, c - a)), ab = (b - a) / along, ac = (c - a) / along;
  }
  template <class Visit>
  void each(const Visit& visit) const {
    const auto at = [&](double u, double v) { return corner + ab * u + ac * v; };
    for (double i = 0.0; i < along; ++i)
      for (double j = 0.0; i + j < along; ++j) {
        visit(at(i + 1.0 / 3.0, j + 1.0 / 3.0));
        if (i + j + 1.0 < along) visit(at(i + 2.0 / 3.0, j + 2.0 / 3.0));
      }
  }
};

class Judge {
 public:
  Judge(const ClField& field, const HullBvh& tree, const PlanOptions& options,
        const EnvelopeOptions& envelope, const CuttingMoves& moves, double limit)
      : field_(field),
        options_(options),
        moves_(moves),
        limit_(limit),
        rules_(options, field),
        piece_(field.surface.pieces().front()),
        envelope_(field.surface, field.deformation, field.index, envelope) {
    envelope_.look_up_in(tree);
  }

  FacetVerdict facet(std::uint32_t i) {
    const Pieces pieces(field_.surface.mesh(), i, piece_, options_);
    FacetVerdict verdict;
    pieces.each([&](Point<Part> place) {
      ++verdict.pieces;
      const std::optional<std::optional<RestReason>> faces = judge(place, pieces.normal, verdict);
      if (!faces) return;
      ++verdict.facing;
      if (*faces) ++verdict.uncut[static_cast<std::size_t>(**faces)];
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
  std::optional<std::optional<RestReason>> judge(Point<Part> place, Vec3 n, FacetVerdict& verdict) {
    const Deformation& map = field_.deformation;
    const AxisLine line = contact_line(piece_, map, place, n);
    const double facing = dot(n, line.axis);
    if (facing < -kWallLean) return std::nullopt;
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
        verdict.fixtures.push_back(field_.surface.facet_of(found->patch));
        return {RestReason::kFixture};
      }
      return {part == ToolPart::kCutter ? by_cutter : rest_reason_of(part)};
    }
    const std::optional<RestReason> refused = rules_.refusal(*found);
    if (refused == RestReason::kFixture) verdict.fixtures.push_back(field_.surface.facet_of(found->patch));
    if (!refused && facing >= kSteepest && off <= options_.tolerance)
      look_between(place, line.base, *found, verdict);
    return {refused};
  }

  /// What the passes leave of a place that the tool reaches.
  void look_between(Point<Part> place, Point<Part> touching, const EnvelopePoint& stand,
                    FacetVerdict& verdict) const {
    const double left = moves_.left(place, touching, kEnough * limit_);
    if (left > limit_) return verdict.over.push_back({left, place, stand});
    if (left > verdict.most) verdict.most = left, verdict.place = place;
  }

  const ClField& field_;
  const PlanOptions& options_;
  const CuttingMoves& moves_;
  double limit_;
  PointRules rules_;
  const ToolPiece& piece_;
  Envelope envelope_;
};

/// What of the pieces over the limit the tool is kept off is uncut; returns how many are left.
std::uint32_t without_kept_off(FacetVerdict& verdict, const KeptOff& kept_off) {
  std::uint32_t over = 0;
  for (const OverLimit& piece : verdict.over) {
    if (kept_off && kept_off(piece.stand)) {
      ++verdict.uncut[static_cast<std::size_t>(RestReason::kShank)];
      continue;
    }
    ++over;
    if (piece.left > verdict.most) verdict.most = piece.left, verdict.place = piece.place;
  }
  return over;
}

}  // namespace

RestReport find_rest_material(const ClField& field, const PlanOptions& options,
                              const EnvelopeOptions& envelope, const std::vector<Move>& path,
                              const ReportShare& report_share, const KeptOff& kept_off) {
  const Mesh& mesh = field.surface.mesh();
  const double limit = asked_height(options) + options.tolerance;
  const CuttingMoves moves(path, field.surface.pieces().front(), reference_height(options.cutter),
                           std::max(asked_step(options), options.pattern.step_down));
  std::vector<FacetVerdict> verdicts(field.surface.part_facets());
  const HullBvh tree = field.index.tree(field.deformation);
  tbb::enumerable_thread_specific<Judge> judges(
      [&] { return Judge(field, tree, options, envelope, moves, limit); });
  Watch watch(report_share, verdicts.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, verdicts.size()), [&](const auto& range) {
    Judge& judge = judges.local();
    for (std::size_t i = range.begin(); i < range.end() && watch.next(); ++i)
      verdicts[i] = judge.facet(static_cast<std::uint32_t>(i));
  });
  RestReport report;
  report.between.limit = limit;
  if (options.fixtures) report.fixture_area.resize(options.fixtures->names.size(), 0.0);
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    FacetVerdict& v = verdicts[i];
    if (v.facing == 0) {
      ++report.away;
      continue;
    }
    const auto& f = mesh.facets[i];
    const double area =
        length(cross(mesh.vertices[f[1]] - mesh.vertices[f[0]], mesh.vertices[f[2]] - mesh.vertices[f[0]])) /
        2.0;
    const std::uint32_t over = without_kept_off(v, kept_off);
    std::uint32_t uncut = 0;
    for (const std::uint32_t n : v.uncut) uncut += n;
    for (const std::uint32_t body : v.fixtures) report.fixture_area[body] += area / v.pieces;
    report.facing_area += area * v.facing / v.pieces;
    BetweenPasses& between = report.between;
    between.area += area * over / v.pieces;
    if (v.most > between.most) between.most = v.most, between.facet = mesh.source[i], between.place = v.place;
    if (uncut == 0) continue;
    const double share = static_cast<double>(uncut) / v.pieces;
    const auto why =
        static_cast<RestReason>(std::max_element(v.uncut.begin(), v.uncut.end()) - v.uncut.begin());
    (why == RestReason::kWall ? report.wall_area : report.area) += area * share;
    report.facets.push_back({mesh.source[i], why, share});
  }
  report.between.never = report.between.most >= moves.farthest();
  report.between.most = std::max(report.between.most, kEnough * limit);
  std::stable_sort(report.facets.begin(), report.facets.end(),
                   [](const RestFacet& a, const RestFacet& b) { return a.facet < b.facet; });
  return report;
}

std::vector<bool> facing_facets(const Mesh& mesh, const PlanOptions& options) {
  const Deformation map(options.axis, 1.0);
  const ToolPiece piece = tool_pieces(options).front();
  std::vector<std::uint8_t> facing(mesh.facets.size());
  tbb::parallel_for(std::size_t{0}, facing.size(), [&](std::size_t i) {
    const Pieces pieces(mesh, static_cast<std::uint32_t>(i), piece, options);
    pieces.each([&](Point<Part> place) {
      const AxisLine line = contact_line(piece, map, place, pieces.normal);
      if (dot(pieces.normal, line.axis) >= -kWallLean) facing[i] = 1;
    });
  });
  return {facing.begin(), facing.end()};
}

}  // namespace tiltfeed::pathgen
