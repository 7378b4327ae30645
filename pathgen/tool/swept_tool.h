#pragma once
// Cutter, shank and holder against the part, exactly: the tool where it stands, and the tool with all the way
// on which it can be drawn back along its axis. (A1)..(A3) in pathgen/free_axis/README.md.

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "kinematics/basics/tool_path.h"
#include "pathgen/mesh/facet_bvh.h"
#include "pathgen/tool/tool_pieces.h"

namespace tiltfeed::pathgen {

/// What of the tool meets which facet (index into the mesh) of the part, or of the fixtures.
struct Blocker {
  ToolPart part = ToolPart::kCutter;
  std::uint32_t facet = 0;
  bool of_fixtures = false;
};

/// Of the tool that is asked about: the cutting part, the shank, too, the holder, too; all against fixtures,
/// too.
inline constexpr int kCutterOnly = 1, kWithShank = 2, kWithHolder = 3, kWithFixtures = 4;

/// Drawn back for ever.
inline constexpr double kForEver = std::numeric_limits<double>::infinity();

/// Which pieces of the tool are asked about.
enum class HeldPieces {
  kOutermost,     ///< those that are in no other's shadow: enough for a tool that is drawn back for ever
  kAll,           ///< those in another's shadow, too: for a tool that is drawn back by some length
  kBesidesCutter  ///< of the outermost ones shank and holder
};

class SweptTool {
 public:
  /// A part of the tool between two heights over the CL reference: a cylinder or a cone that widens upwards.
  struct Frustum {
    ToolPart part = ToolPart::kCutter;
    double from = 0.0, to = 0.0;  ///< mm; to: may be infinite
    double radius = 0.0;          ///< at the lower end, mm
    double slope = 0.0;           ///< by which the radius grows over the height
    double widest = 0.0;          ///< radius at the upper end, mm
    double top = 0.0;             ///< of the piece where the tool stands, mm
    bool sharp = false;           ///< its lower end is wider than the tool below it
  };

  /// Fixtures of the options are held against all of the tool, its ball included, grown by their room.
  /// `slack`: by which the cutting part may cut in, mm; it touches the part where it works. `tree` must
  /// outlive the tool. Requires: a ball or taper-ball cutter.
  SweptTool(const FacetBvh& tree, const PlanOptions& options, double slack,
            HeldPieces held = HeldPieces::kOutermost);

  /// What stops the tool from standing with its CL reference (the ball's centre) at `centre` and being drawn
  /// back along `axis` (unit) for ever. The ball itself is not asked about where it stands: it touches there.
  /// `hint`: the facet that stopped a tool nearby; it is asked first, and set to what is found. Safe to call
  /// from several threads.
  std::optional<Blocker> stop(Point<Part> centre, Vec3 axis, std::uint32_t& hint) const;
  /// The same for `parts` of it, kCutterOnly to kWithFixtures, drawn back by `back` (mm).
  std::optional<Blocker> stop(Point<Part> centre, Vec3 axis, std::uint32_t& hint, int parts,
                              double back = kForEver) const;
  /// Is it this facet that stops the first `parts` of the tool there?
  bool stopped_by(std::uint32_t facet, Point<Part> centre, Vec3 axis, int parts) const;
  /// Does anything stop the tool, drawn back as above, on a move during which the reference stays within
  /// `off` (mm) of `centre` and the axis within `turn` (rad) of `axis`? Only what of the tool is higher than
  /// `from` over the reference is asked. No answer is wrong that says it is clear.
  bool may_stop(Point<Part> centre, Vec3 axis, double off, double turn, double from,
                double back = kForEver) const;
  /// As stop(), of what of the tool is lower than `to` over the reference; nothing is swept higher. Sharp
  /// lower ends reach further down, by `fall` (mm) and by their radius times `turn` (rad).
  bool stopped_below(Point<Part> centre, Vec3 axis, double to, double fall, double turn, std::uint32_t& hint,
                     double back = kForEver) const;
  /// What the tool as it stands, ball and all, meets; nothing is swept.
  std::optional<Blocker> hit(Point<Part> centre, Vec3 axis) const;

  double ball() const { return ball_; }           ///< radius of the ball with the allowance, mm
  double widest() const { return widest_; }       ///< of any part of the tool, mm
  double top() const { return top_; }             ///< of the tool over the CL reference, mm
  const FacetBvh& tree() const { return tree_; }  ///< of the part
  /// Round part and fixtures.
  Box bounds() const;
  /// The tool as fixtures meet it; null: there are none.
  const SweptTool* at_fixtures() const { return fixtures_.get(); }

 private:
  std::optional<Blocker> stop_at_fixtures(Point<Part> centre, Vec3 axis, double back) const;
  bool ball_meets(Point<Part> centre, double radius, std::uint32_t* facet = nullptr) const;

  const FacetBvh& tree_;
  std::shared_ptr<const FacetBvh> fixture_tree_;
  std::shared_ptr<const SweptTool> fixtures_;
  HeldPieces held_;
  double ball_, slack_, widest_ = 0.0, top_ = 0.0;
  std::vector<Frustum> swept_;  ///< of the held pieces, from the tip up
  std::vector<Frustum> still_;
};

/// Does the frustum, its lower end at `centre` + from `axis`, meet the facet? Exact but for rounding.
bool meets(const SweptTool::Frustum& frustum, Point<Part> centre, Vec3 axis, const PlacedFacet& facet);

/// The place of the triangle that is nearest to p.
Point<Part> nearest_point(Point<Part> p, const Corners& triangle);

}  // namespace tiltfeed::pathgen
