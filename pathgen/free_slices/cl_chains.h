#pragma once
// From the strands of one section of the CL surface to passes: what is inside the offset is cut away, ends
// that meet are joined. (N4)..(N6) in pathgen/free_slices/README.md.

#include <cstdint>
#include <span>
#include <vector>

#include "pathgen/free_slices/cl_sections.h"
#include "pathgen/mesh/facet_bvh.h"

namespace tiltfeed::pathgen {

/// Places of the centre, each straight on to the next; closed: the last one is the first again.
struct ClChain {
  ClStrand points;
  bool closed = false;
};

/// (N4) The parts of the strand whose centres are nowhere nearer to one of `obstacles` (indices into the
/// mesh) than `radius`, less kInside: exact on every straight move. Ends of what is cut away belong to what
/// is left.
void trim_strand(const ClStrand& strand, const FacetBvh& tree, std::span<const std::uint32_t> obstacles,
                 double radius, std::vector<ClStrand>& kept);

/// A ball this much (mm) inside a facet still only touches it: rounding.
inline constexpr double kInside = 1e-8;

struct JoinLimits {
  double gap = 0.0;       ///< ends this near (mm) are one
  double wide_gap = 0.0;  ///< ends this near are joined where the straight move is contact within `tolerance`
  double tolerance = 0.0;  ///< mm
  double shortest = 0.0;   ///< shorter chains are dropped, mm
};

/// (N5) Joins each end of a strand to the nearest start; near ones first. The strands run one way; which are
/// joined does not depend on their order.
std::vector<ClChain> join_strands(std::vector<ClStrand> strands, const FacetBvh& tree, double radius,
                                  const JoinLimits& limits);

/// (N6) Drops points that a straight move passes within `tolerance`, while normals in between stay within
/// kNormalBend (rad) of what lies between those of its ends.
void thin_chain(ClChain& chain, double tolerance);
inline constexpr double kNormalBend = 0.1;

/// Is the centre's straight move nowhere nearer to the part than the radius, and nowhere further off, but for
/// the tolerance?
bool in_contact(Point<Part> from, Point<Part> to, const FacetBvh& tree, double radius, double tolerance);

double length_of(const ClStrand& strand);

/// The place at the share f of the straight move from a to b.
ClPoint between(const ClPoint& a, const ClPoint& b, double f);
/// Points nearer than this, mm, are one.
inline constexpr double kSamePoint = 1e-7;

}  // namespace tiltfeed::pathgen
