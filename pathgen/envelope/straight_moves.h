#pragma once
// May the tool go straight from one point of the envelope to the next? (E2), (E3) in
// pathgen/envelope/README.md.

#include <span>

#include "pathgen/envelope/pass.h"
#include "pathgen/surface/candidates.h"

namespace tiltfeed::pathgen {

/// What the envelope is at one run coordinate of a line: a point, or nothing.
struct Sample {
  double run = 0.0;
  bool hit = false;
  EnvelopePoint point;
};

/// One object a thread.
class StraightMoves {
 public:
  /// Both must outlive it. `stretch`: no mm of the line is more on the CL surface, mm.
  StraightMoves(const ClSurface& surface, const EnvelopeOptions& options, double stretch);

  /// What the two ends of a move tell of it.
  struct Verdict {
    /// The axis turns little, the move is not too long, and no curved sheet but those that the ends lie on
    /// rises over it by more than the tolerance.
    bool joined = false;
    /// How far the tangent planes at the ends are from the other end, mm. The envelope between leaves the
    /// move by no more than the smaller if it is two planes, by a quarter of either if it is an arc.
    double larger = 0.0, smaller = 0.0;
    bool corner_at_end = false;  ///< joined, and the smaller is within the tolerance
    /// There are only two planes between the ends, and a ball's arc below where these meet: a corner at an
    /// end, and the ends lie on two facets with the way over their common edge.
    bool over_one_edge = false;
    /// So, or the ends lie on one sheet, or the move is so short that the tool sinks between other sheets by
    /// less than the tolerance.
    bool unbroken = false;
  };
  /// `active`: all that may be highest between them, and not only there.
  Verdict judge(const Sample& left, const Sample& right, std::span<const Candidate> active) const;

  /// Is a sample between two others within the tolerance of the move?
  bool on_move(const Sample& sample, const Sample& left, const Sample& right) const;

  /// Is the middle on the sheet of one of the ends, so that there is a corner beside the other at most?
  /// Requires: unbroken.
  static bool one_corner(const Sample& left, const Sample& middle, const Sample& right);

  /// Do the sheets of the ends share no edge or corner on the way, and may a sharp lower edge sink between
  /// them by more than the tolerance? It has no rounding: it goes down a slope of any steepness to the next
  /// sheet.
  bool may_sink(const EnvelopePoint& a, const EnvelopePoint& b) const;

  /// Where between the ends to look next, as a share of the way: where two planes meet; the first of as many
  /// parts as an arc needs; else half way.
  double next_share(const Sample& left, const Sample& right, const Verdict& move) const;

  /// A flat end that lies on two features in one plane tells nothing of what is between them.
  bool stands_level_on_two(const Sample& left, const Sample& right) const;

  /// What reaches over less of the line than this (mm) rises over a move by less than the tolerance.
  double close() const { return close_; }

 private:
  bool turns_little(const EnvelopePoint& a, const EnvelopePoint& b, double length2) const;
  bool another_curved_sheet(const Sample& left, const Sample& right, std::span<const Candidate> active) const;
  bool keeps_off(PatchId patch, const EnvelopePoint& a, const EnvelopePoint& b) const;
  bool crosses_one_edge(const EnvelopePoint& a, const EnvelopePoint& b) const;
  bool core_keeps_off(PatchId patch, const EnvelopePoint& a, const EnvelopePoint& b) const;

  const ClSurface& surface_;
  const EnvelopeOptions& options_;
  /// Over a gap of this length (mm) between two points of one sheet another curved sheet rises by its
  /// sagitta, the tolerance.
  double curved_step_;
  double close_;
  bool sharp_;                    ///< a piece has a sharp lower edge
  mutable std::size_t rose_ = 0;  ///< which of the active did last
};

}  // namespace tiltfeed::pathgen
