#pragma once
// What the tool shows to a part below it: convex pieces, each a flat disc whose edge is rounded and runs out
// into a cone. Dropped along the axis, the highest piece decides. (T1)..(T3) in pathgen/tool/README.md.

#include <vector>

#include "pathgen/options/plan_options.h"

namespace tiltfeed::pathgen {

/// Seen from below, at distance d from the axis: a disc up to `flat`, an arc of radius `corner` up to the
/// cone, the cone up to `outer`, and a straight wall above. Heights are over the *ring centre*: the plane in
/// which the arc's centre runs round the axis.
struct ToolPiece {
  ToolPart part = ToolPart::kCutter;
  bool at_fixtures = false;                 ///< meets fixtures and nothing of the part; else the other way
  double flat = 0.0, corner = 0.0;          ///< mm; a ball has flat 0, a sharp edge corner 0
  double taper_sin = 0.0, taper_cos = 1.0;  ///< of the cone's half-angle; 0: straight wall
  double outer = 0.0;                       ///< mm; flat + corner for a straight wall
  double above_reference = 0.0;             ///< ring centre over the CL reference, mm
  double length = 0.0;                      ///< from the ring centre to the piece's upper end, mm

  bool is_ball() const { return flat == 0.0 && taper_sin == 0.0; }
  /// A ball whose centre is the CL reference.
  bool is_ball_at_reference() const { return is_ball() && above_reference == 0.0; }
  bool has_cone() const { return taper_sin > 0.0; }
  /// Height of the cone at distance d from the axis. Requires: has_cone().
  double cone_height(double d) const {
    return (d - flat - corner * taper_cos) * taper_cos / taper_sin - corner * taper_sin;
  }
};

/// Distance of a point from the outside of the piece's lower side, mm, negative within; `d` from the axis,
/// `h` over the ring centre.
double distance_to_piece(const ToolPiece& piece, double d, double h);

/// Height of the CL reference over the tip, mm: the centre of the ball or of the rounded edge.
inline double reference_height(const Cutter& cutter) { return cutter.nose_radius(); }

/// Every piece of the tool, from the tip up; the first is the cutting part. Grown as below.
std::vector<ToolPiece> all_pieces(const PlanOptions& options);

/// Of each of them: does it, with its clearance, stick out nowhere from a piece below it?
std::vector<bool> in_shadow(const PlanOptions& options);

/// The pieces that are in no shadow, from the tip up; the first is the cutting part. Grown by the stock that
/// is to stay, shank and holder by their clearances besides.
std::vector<ToolPiece> tool_pieces(const PlanOptions& options);

/// (T1) What may stay besides the allowance where the upper edge of a taper's cone touches, mm.
double left_at_taper_edge(const PlanOptions& options);

/// (T4) The pieces that fixtures see, likewise: grown by PlanOptions::fixture_room alone.
std::vector<ToolPiece> fixture_pieces(const PlanOptions& options);
/// The options of a part from which the tool is to keep as far off as from a fixture.
PlanOptions as_of_fixtures(PlanOptions options);

/// The options of the same tool without the parts whose guard lets the tool lean: those neither reach out
/// further than the cutting part nor have a guard.
PlanOptions without_leaning_parts(PlanOptions options);

/// (T3) The same with a straight piece before each cone that has a sharp lower edge.
std::vector<ToolPiece> with_lower_discs(const std::vector<ToolPiece>& pieces);

}  // namespace tiltfeed::pathgen
