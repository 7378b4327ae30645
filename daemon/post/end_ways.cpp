#include "daemon/post/end_ways.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "pathgen/mesh/facet_bvh.h"
#include "pathgen/tool/blank_solid.h"
#include "pathgen/tool/swept_tool.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::daemon {
namespace {

// A tool nearer to the machine's Z than this is along it, sine: it drifts by 1 mm over a metre.
constexpr double kAlongZ = 1e-3;
// A plane that the tool axis leaves at a flatter angle than this is not sought, sine.
constexpr double kLeastLeaving = 0.1;

/// A piece of the tool, as the part meets it or as fixtures do.
struct MetPiece {
  pathgen::ToolPiece piece;
  bool by_fixtures = false;
};

std::vector<MetPiece> pieces_of(const pathgen::PlanOptions& options) {
  std::vector<MetPiece> pieces;
  for (const pathgen::ToolPiece& piece : pathgen::all_pieces(options)) pieces.push_back({piece, false});
  if (options.fixtures)
    for (const pathgen::ToolPiece& piece : pathgen::all_pieces(pathgen::as_of_fixtures(options)))
      pieces.push_back({piece, true});
  return pieces;
}

pathgen::PlanOptions without_clearances(pathgen::PlanOptions options) {
  options.shank.clearance = options.holder.clearance = 0.0;
  return options;
}

/// With room for stock on the part.
pathgen::PlanOptions over_stock(pathgen::PlanOptions options) {
  const double room = 0.5 * options.links.approach;
  options.allowance += room;
  options.fixture_room.cutter += room, options.fixture_room.shank += room,
      options.fixture_room.holder += room;
  return options;
}

/// Where the tool can stand at a pose, and the machine's Z there.
struct Stand {
  Joints words;
  Vec3 z;  ///< unit, part frame
};

class EndWays {
 public:
  EndWays(const pathgen::Mesh& part, const config::Job& job)
      : part_(part),
        job_(job),
        pieces_(pieces_of(job.plan)),
        close_pieces_(pieces_of(without_clearances(job.plan))),
        stock_pieces_(pieces_of(over_stock(without_clearances(job.plan)))),
        base_(pathgen::reference_height(job.plan.cutter)) {
    const std::size_t blank = job.plan.blank ? job.plan.blank->mesh().facets.size() : 0;
    fixtures_end_ = part.facets.size() - std::min(part.facets.size(), blank);
    const std::size_t count = job.plan.fixtures ? job.plan.fixtures->mesh.facets.size() : 0;
    fixtures_begin_ = fixtures_end_ - std::min(fixtures_end_, count);
  }

  /// How far along its axis the tool is to go; 0: it need not, or there is no way.
  double way(const Pose& pose);
  /// Of that way: a rapid keeps off by half of the approach, which may stand on the part as stock.
  MoveKind kind(const Pose& pose, double way) {
    return clear(pose, way, stock_pieces_) ? MoveKind::kRapid : MoveKind::kPlunge;
  }

 private:
  std::vector<Stand> stands(const Pose& pose) const;
  std::optional<double> beyond(const Pose& pose, Vec3 normal) const;
  bool in_reach(const Pose& pose, const std::vector<Stand>& stands) const;
  bool is_fixture(std::size_t facet) const { return facet >= fixtures_begin_ && facet < fixtures_end_; }
  bool clear(const Pose& pose, double way, const std::vector<MetPiece>& pieces);

  const pathgen::Mesh& part_;
  const config::Job& job_;
  std::vector<MetPiece> pieces_, close_pieces_;        ///< with the guards' clearances, and without
  std::vector<MetPiece> stock_pieces_;                 ///< without, but with room for stock
  std::size_t fixtures_begin_ = 0, fixtures_end_ = 0;  ///< facets of part_ that are those of fixtures
  double base_;                                        ///< of the CL reference over the tip, mm
  std::optional<pathgen::FacetBvh> tree_;              ///< made when first needed
};

/// With both solutions of the tilt: which of them is taken depends on the whole path.
std::vector<Stand> EndWays::stands(const Pose& pose) const {
  const MachineModel& machine = job_.machine.model;
  std::vector<Stand> found;
  const auto solutions = inverse(machine, job_.setup, pose, 0.0);
  if (!solutions) return found;
  for (const Joints& words : *solutions) {
    const bool tilts = words.a >= machine.tilt.min && words.a <= machine.tilt.max;
    if (machine.tilt.present && !tilts) continue;
    Joints higher = words;
    higher.z += 1.0;
    found.push_back({words, normalized(forward(machine, job_.setup, higher).tip -
                                       forward(machine, job_.setup, words).tip)});
  }
  return found;
}

/// How far along its axis all of the tool is beyond the plane with this normal that is the clearance off the
/// part.
std::optional<double> EndWays::beyond(const Pose& pose, Vec3 normal) const {
  const double along = dot(pose.axis, normal), across = std::sqrt(std::max(0.0, 1.0 - along * along));
  if (along < kLeastLeaving) return std::nullopt;
  double lowest = 0.0, top = -std::numeric_limits<double>::infinity();
  for (const auto& [piece, by_fixtures] : pieces_) {
    const double ring = base_ + piece.above_reference;
    lowest = std::min(lowest, ring * along - piece.flat * across - piece.corner);
    if (piece.has_cone())
      lowest = std::min(lowest, (ring + piece.cone_height(piece.outer)) * along - piece.outer * across);
  }
  for (const Point<Part>& v : part_.vertices) top = std::max(top, dot(v - pose.tip, normal));
  return std::max(0.0, (top + job_.plan.links.clearance - lowest) / along);
}

bool EndWays::in_reach(const Pose& pose, const std::vector<Stand>& stands) const {
  const MachineModel& m = job_.machine.model;
  const auto holds = [](const LinearAxis& axis, double at) { return at >= axis.min && at <= axis.max; };
  return std::all_of(stands.begin(), stands.end(), [&](const Stand& stand) {
    const Joints at = solve_linear(m, job_.setup, pose.tip, stand.words.a, stand.words.c);
    return holds(m.x, at.x) && holds(m.y, at.y) && holds(m.z, at.z);
  });
}

/// Nothing of the part is in the way along the axis. Where the tool begins it is clear.
bool EndWays::clear(const Pose& pose, double way, const std::vector<MetPiece>& pieces) {
  if (!tree_) tree_.emplace(part_);
  const Point<Part> reference = pose.tip + pose.axis * base_;
  const auto meets_part = [&](const pathgen::SweptTool::Frustum& frustum, bool by_fixtures) {
    return tree_->any_along(reference, pose.axis, frustum.from, frustum.to, frustum.widest,
                            [&](std::uint32_t i, const pathgen::PlacedFacet& facet) {
                              return is_fixture(i) == by_fixtures &&
                                     pathgen::meets(frustum, reference, pose.axis, facet);
                            });
  };
  return std::none_of(pieces.begin(), pieces.end(), [&](const MetPiece& met) {
    const pathgen::ToolPiece& piece = met.piece;
    const double ring = piece.above_reference, end = ring + piece.length + way;
    if (!piece.has_cone())
      return meets_part({piece.part, ring, end, piece.outer, 0.0, piece.outer}, met.by_fixtures);
    const double slope = piece.taper_sin / piece.taper_cos, wide = ring + piece.cone_height(piece.outer),
                 radius = piece.flat + piece.corner / piece.taper_cos;
    return meets_part({piece.part, ring, wide, radius, slope, piece.outer}, met.by_fixtures) ||
           meets_part({piece.part, wide, end, piece.outer, 0.0, piece.outer}, met.by_fixtures);
  });
}

double EndWays::way(const Pose& pose) {
  const std::vector<Stand> stands = this->stands(pose);
  const Vec3 a = pose.axis;
  const bool leans = std::any_of(stands.begin(), stands.end(),
                                 [&](const Stand& stand) { return length(cross(stand.z, a)) > kAlongZ; });
  if (!leans) return 0.0;
  // Of each kind of plane the furthest of all stands. Up and down the tool stays beyond each of them.
  std::optional<double> over = 0.0, beside = 0.0, square = 0.0;
  const auto widen = [](std::optional<double>& all, std::optional<double> one) {
    all = all && one ? std::optional(std::max(*all, *one)) : std::nullopt;
  };
  for (const Stand& stand : stands) {
    const Vec3 level = a - stand.z * dot(a, stand.z);
    widen(over, beyond(pose, stand.z));
    widen(beside, length(level) > kLeastLeaving ? beyond(pose, normalized(level)) : std::nullopt);
    widen(square, dot(a, stand.z) > 0.0 ? beyond(pose, a) : std::nullopt);
  }
  if (over && beside && *beside < *over) std::swap(over, beside);
  for (const auto* pieces : {&pieces_, &close_pieces_})
    for (const std::optional<double>& way : {over, beside, square}) {
      if (!way) continue;
      if (*way == 0.0) return 0.0;
      if (in_reach({pose.tip + a * *way, a}, stands) && clear(pose, *way, *pieces)) return *way;
    }
  return 0.0;
}

}  // namespace

double add_end_ways(ToolPath& path, const pathgen::Mesh& part, const config::Job& job) {
  EndWays ends(part, job);
  const Pose first = path.moves.front().pose, last = path.moves.back().pose;
  const double off = ends.way(last), above = ends.way(first);
  if (off > 0.0)
    path.moves.push_back({{last.tip + last.axis * off, last.axis}, ends.kind(last, off), kNoFacet});
  if (above > 0.0) {
    path.moves.front().kind = ends.kind(first, above);
    path.moves.insert(path.moves.begin(),
                      {{first.tip + first.axis * above, first.axis}, MoveKind::kRapid, kNoFacet});
    for (FeedChange& change : path.feeds) ++change.move;
  }
  return off + above;
}

}  // namespace tiltfeed::daemon
