#pragma once
// The tool on the axis of the mode, and leaning from it about its ball, against part and fixtures. (Y1), (Y2)
// in pathgen/lean/README.md.

#include <cstdint>
#include <optional>

#include "pathgen/axis/deformation.h"
#include "pathgen/envelope/pass.h"
#include "pathgen/mesh/facet_bvh.h"
#include "pathgen/options/plan_options.h"
#include "pathgen/tool/move_collision.h"
#include "pathgen/tool/swept_tool.h"

namespace tiltfeed::pathgen {

/// Safe to be asked from several threads. `hint`: as SweptTool::stop.
class LeanTool {
 public:
  /// All must outlive it. `clearance_z`: z' of the clearance surface, up to which the tool is drawn back.
  /// Requires: a ball or taper-ball cutter.
  LeanTool(const Mesh& part, const PlanOptions& options, const Deformation& map, double clearance_z);

  /// What shank or holder meet, or come nearer to than their clearance, with the tool on the mode's axis.
  std::optional<Blocker> held(const EnvelopePoint& p, std::uint32_t& hint) const;
  /// Are both clear there with the tool on the mode's axis, and on a short move along `before` or `ahead`
  /// (unit or 0)?
  bool clear_upright(const EnvelopePoint& p, Vec3 before, Vec3 ahead, std::uint32_t& hint) const;
  /// Are both clear all along the straight move, with the tool on the mode's axis?
  bool clear_upright(const EnvelopePoint& a, const EnvelopePoint& b, std::uint32_t& hint) const;

  /// May the tool lean there at all: does its ball touch, and not its cone?
  bool touches_with_ball(const EnvelopePoint& p) const;
  /// Is the whole tool clear with this axis, drawn back along it up to the clearance surface, there and on a
  /// short move along `before` or `ahead` (unit or 0) on which it turns a little?
  bool clear(const EnvelopePoint& p, Vec3 axis, Vec3 before, Vec3 ahead, std::uint32_t& hint) const;
  /// The same all along the straight move from a, with the axis `from`, to b, with the axis `to`.
  bool clear(const EnvelopePoint& a, Vec3 from, const EnvelopePoint& b, Vec3 to, std::uint32_t& hint) const;
  /// The tool as it stands, ball and all, on a move off the part: nothing is drawn back.
  bool clear_off_part(const ToolStand& from, const ToolStand& to) const;
  /// How far over a place, along this axis, the tool grown by `approach` first touches on its way down, mm:
  /// at least `approach`.
  double rapid_end(const EnvelopePoint& p, Vec3 axis) const;
  /// How far the tool is drawn back from there along this axis, mm.
  double way_back(const EnvelopePoint& p, Vec3 axis) const;

  const PlanOptions& options() const { return options_; }
  const Deformation& map() const { return map_; }
  double clearance_z() const { return clearance_z_; }
  /// Largest turn of the axis in one move, rad.
  double largest_turn() const { return largest_turn_; }

 private:
  const PlanOptions& options_;
  const Deformation& map_;
  double clearance_z_, largest_turn_, reference_height_;
  double tolerance_;  ///< to which moves are looked at, mm
  double step_;       ///< no point of the tool moves further between two poses that are looked at, mm
  FacetBvh tree_;
  SweptTool tool_, guards_, grown_;
  TiltLimit tilt_;
};

}  // namespace tiltfeed::pathgen
