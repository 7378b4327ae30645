#pragma once
// The whole tool (cutting part, shank, holder) as a union of convex solids of revolution, against the part's
// surface. Independent of the planner: what a Cutter looks like is read here a second time.

#include <array>
#include <optional>
#include <vector>

#include "pathgen/options/cutter.h"
#include "sim/solid/distance.h"
#include "sim/solid/revolved.h"

namespace tiltfeed::sim {

enum class ToolPart : int { kCutter, kShank, kHolder };
inline constexpr std::array<ToolPart, 3> kToolParts{ToolPart::kCutter, ToolPart::kShank, ToolPart::kHolder};
inline constexpr std::array<const char*, 3> kToolPartNames{"cutter", "shank", "holder"};

/// What the tool is grown by, mm: the stock that shall stay on the part.
struct Growth {
  double allowance = 0.0;  ///< along the part's normal
  double radial = 0.0;     ///< square to the tool axis
  double axial = 0.0;      ///< along the tool axis, at the lower end
};

/// Least signed distance of a convex solid at a pose from the surface, if below `bound` (which may be
/// negative): negative is the depth of an overlap, the least by which the solid must shrink to be free of the
/// surface. At a sharp rim that is up to sqrt(2) less than the rim's depth along the surface's normal.
Hit clearance(const PartDistance& surface, const Revolved& solid, const Pose& pose, double bound = kInfinity,
              std::uint32_t hint = kNoFacet);
/// How far the solid moves along -axis until its lower border touches the surface, if below `bound`; 0 where
/// it does from the start. What lies above the solid's widest place is not looked at. `enough`: any value up
/// to it will do, the least is not searched for; it only saves time.
Hit drop(const PartDistance& surface, const Revolved& solid, const Pose& pose, double bound = kInfinity,
         std::uint32_t hint = kNoFacet, double enough = -kInfinity);

class ToolSolid {
 public:
  /// Parts that meet reach this far into each other where one fits into the other, so that an overlap just at
  /// the joint is measured right up to this depth, mm.
  static constexpr double kJointOverlap = 0.1;

  /// Requires: 0 < diameter, heights ascending, as config/job.cpp checks. All parts are grown alike.
  /// `overlap`: of parts that meet, mm; with 0 distances are those of each part itself.
  explicit ToolSolid(const pathgen::Cutter& cutter, const Growth& growth = {},
                     double overlap = kJointOverlap);

  bool has(ToolPart part) const { return !pieces_[static_cast<int>(part)].empty(); }
  /// Least signed distance of that part of the tool, as above; `bound` where the tool has none.
  Hit clearance(const PartDistance& surface, const Pose& pose, ToolPart part, double bound = kInfinity,
                std::uint32_t hint = kNoFacet) const;
  /// Distance of the end (below the upper end of its rounding; all of a ball), as above.
  Hit gap(const PartDistance& surface, const Pose& pose, double bound = kInfinity,
          std::uint32_t hint = kNoFacet) const;
  /// The drop of the cutting part, as above.
  Hit drop(const PartDistance& surface, const Pose& pose, double bound = kInfinity,
           std::uint32_t hint = kNoFacet, double enough = -kInfinity) const;

  double widest() const;     ///< largest radius of any piece, mm
  double narrowest() const;  ///< least of the pieces' largest radii, mm
  double top() const;        ///< height of the upper end over the tip, mm
  const std::vector<Revolved>& pieces(ToolPart part) const { return pieces_[static_cast<int>(part)]; }
  /// The cutting part alone, with no joint.
  const Revolved& cutting() const { return cutting_.front(); }

 private:
  /// (V8) A ball with a shank of its own diameter and nothing above: it holds all that is within `radius` of
  /// the segment centre..within, and nothing further than `radius` from centre..upper. Its upper end is flat:
  /// the dome over it is not the tool's.
  struct Capsule {
    double centre = 0.0, within = 0.0, upper = 0.0, radius = 0.0;
  };
  std::array<std::vector<Revolved>, 3> pieces_;
  std::vector<Revolved> cutting_, end_;  ///< one each
  std::optional<Capsule> capsule_;
};

}  // namespace tiltfeed::sim
