// Where a move comes nearest to a facet, and what is told of it.

#include <algorithm>
#include <cmath>

#include "sim/proof/proof_run.h"

namespace tiltfeed::sim {
namespace {

// Of a move that cuts too deep the depth is measured at so many places.
constexpr int kPlaces = 16;

}  // namespace

/// A plane, or else the distance of core and facet, tells them apart. `nearest`: along along_, of the core.
bool Prover::Run::clear(const Node& node, double nearest, const Triangle& facet, bool divides,
                        double& width) {
  const double need = enough(node), at_a = dot(along_, from_origin(facet.a));
  if (nearest - at_a - std::max({0.0, dot(along_, facet.ab), dot(along_, facet.ac)}) >= need) return true;
  const Gap gap = gap_to(node, facet, need, divides ? need : 0.0);
  width = gap.width;
  if (gap.width < need) return false;
  along_ = gap.along;
  return true;
}

/// (P1) Between the hull of the core at both ends and the facet.
Gap Prover::Run::gap_to(const Node& node, const Triangle& facet, double need, double hopeless) const {
  const Vec3 a = from_origin(facet.a), b = a + facet.ab, c = a + facet.ac;
  const auto difference = [&](Vec3 u) {
    const double at_a = dot(u, a), at_b = dot(u, b), at_c = dot(u, c);
    const Vec3 corner = at_a >= at_b && at_a >= at_c ? a : at_b >= at_c ? b : c;
    return furthest(node, -u) - corner;
  };
  const Vec3 from_a = (node.ends[0] + node.ends[2]) * 0.5 - a;
  Vec3 guess = dot(facet.normal, from_a) >= 0.0 ? facet.normal : -facet.normal;
  if (guess == Vec3{}) guess = from_a == Vec3{} ? Vec3{0, 0, 1} : normalized(from_a);
  return gap_between(difference, guess, need, kGapError, hopeless);
}

/// The gap between the core, where it is at a share of the node's move, and the facet.
double Prover::Run::width_at(const Node& node, double share, const Triangle& facet) const {
  Node there = node;
  there.from = there.to = prover_.frames_.pose(moves_[node.first], share);
  there = with_ends(there);
  return gap_to(there, facet, kInfinity, 0.0).width;
}

/// (P5) Where on the node the core is nearest to the facet, or nearer than `enough`: as long as the tool
/// hardly turns, its distance has one valley. Places are told apart by what the core moves between them,
/// `fine`.
double Prover::Run::nearest_share(const Node& node, const Triangle& facet, double enough, double fine,
                                  double& width) const {
  double best = 0.5 * (node.begin + node.end);
  width = width_at(node, best, facet);
  const auto look = [&](double share) {
    const double here = width_at(node, share, facet);
    if (here < width) width = here, best = share;
    return here;
  };
  double low = node.begin, high = node.end;
  const double finest = fine / std::max(length_of(node), fine) * (high - low);
  look(low), look(high);
  while (width > enough && high - low > finest) {
    const double one = low + (high - low) / 3.0, two = high - (high - low) / 3.0;
    if (look(one) < look(two)) {
      high = two;
    } else {
      low = one;
    }
  }
  return best;
}

/// How deep the tool is in the part at a share of the node's move, and at places of the whole of it.
void Prover::Run::tell(const Node& node, double at, double depth, const Triangle& facet) {
  level_ = std::max(level_, depth);
  if (depth <= prover_.tolerance_ * (1.0 + kProofError)) return;
  ++told_, told_move_ = node.first;
  const ProgramMove& move = moves_[node.first];
  for (int i = -1; i <= kPlaces; ++i) {
    const double share = i < 0 ? at : static_cast<double>(i) / kPlaces;
    const Pose pose = prover_.frames_.pose(move, share);
    const Hit hit = prover_.solid_.clearance(prover_.surface_, pose, core_->part, 0.0, facet.facet);
    const double deep = std::max(i < 0 ? depth : 0.0, hit.facet == kNoFacet ? 0.0 : -hit.value);
    if (proof_.deepest && proof_.deepest->depth >= deep) continue;
    const std::uint32_t where = hit.facet == kNoFacet ? facet.facet : hit.facet;
    level_ = std::max(level_, deep);
    proof_.deepest = ProvenGouge{
        core_->part, deep, move.rapid, move.line, move.block, pose, prover_.part_.mesh.source[where]};
  }
}

}  // namespace tiltfeed::sim
