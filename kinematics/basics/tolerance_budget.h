#pragma once
// Who may spend how much of a job's tolerance. Errors that can occur at one place, in one direction, add;
// their shares sum to at most 1 (B1..B7 in kinematics/basics/README.md). Whoever spends takes the share by
// its name from here.

namespace tiltfeed {

class ToleranceBudget {
 public:
  /// `tolerance`: of the job, mm: the largest gouge, and the largest gap where contact is meant.
  explicit constexpr ToleranceBudget(double tolerance) : tolerance_(tolerance) {}

  /// Of a part whose file holds surfaces (STEP, IGES): its facets leave them by so much, mm. It is taken from
  /// the job's tolerance first; all others share the rest.
  static constexpr double tessellation(double tolerance) { return kTessellation * tolerance; }

  // Of every job, mm.
  constexpr double repair() const { return kRepair * tolerance_; }  ///< the part's surface moves
  constexpr double joints() const {
    return kJoints * tolerance_;
  }  ///< tip and shank's end as the axes move, words included
  /// The same where the axis may lean near the pole.
  constexpr double joints_beside_pole() const { return (kJoints - kPole) * tolerance_; }
  constexpr double pole() const { return kPole * tolerance_; }  ///< the ball's centre between bent poses
  constexpr double words() const {
    return kWords * tolerance_;
  }  ///< of joints: the axis under TCP, at the shank's end
  /// What is left of joints for the path that words under TCP are made from.
  constexpr double joints_before_words() const { return (kJoints - kWords) * tolerance_; }

  // Of the axis modes with a predefined axis, mm.
  constexpr double envelope() const { return kEnvelope * tolerance_; }  ///< straight moves off the envelope
  constexpr double thinning() const { return kThinning * tolerance_; }  ///< straight moves off dropped points
  constexpr double turn() const {
    return kTurn * tolerance_;
  }  ///< the ball's bow while the axis turns in a move
  /// The same of the shank's end, with what the axis turns otherwise than evenly.
  constexpr double shank_turn() const { return kShankTurn * tolerance_; }
  /// What is thinned twice has half of it each time; after the first, this is how far it may be off contact.
  constexpr double half_thinned() const { return (kEnvelope + kThinning / 2.0) * tolerance_; }

  // With the axis free, mm.
  constexpr double chords() const { return kChords * tolerance_; }  ///< chords outside their arcs
  constexpr double free_thinning() const { return kFreeThinning * tolerance_; }
  constexpr double gaps() const { return kGaps * tolerance_; }      ///< ends of strands taken as one
  constexpr double flank() const { return kFlank * tolerance_; }    ///< the side may cut in at a checked pose
  constexpr double corner() const { return kCorner * tolerance_; }  ///< and more between two of them
  /// The side may seem to cut in so far where it touches: directions (3+2) and leans are judged with it.
  constexpr double touch() const { return kTouch * tolerance_; }

 private:
  static constexpr double kTessellation = 0.20;
  static constexpr double kRepair = 0.10, kJoints = 0.35, kPole = 0.10, kWords = 0.15;
  static constexpr double kEnvelope = 0.20, kThinning = 0.20, kTurn = 0.05, kShankTurn = 0.15;
  static constexpr double kChords = 0.12, kFreeThinning = 0.24, kGaps = 0.14;
  static constexpr double kFlank = 0.40, kCorner = 0.15, kTouch = 0.25;
  static constexpr double kAll = 1.0 + 1e-12;  ///< the sums are rounded

  static_assert(kTessellation > 0.0 && kTessellation + (1.0 - kTessellation) <= kAll);  // (B7)
  static_assert(kPole < kJoints && kWords < kJoints && kTouch <= kFlank && kTurn <= kShankTurn);
  static_assert(kRepair + kEnvelope + kThinning + kShankTurn + kJoints <= kAll);       // (B1), (B4)
  static_assert(kRepair + kChords + kFreeThinning + kGaps + kTurn + kJoints <= kAll);  // (B2)
  static_assert(kRepair + kFlank + kCorner + kJoints <= kAll);                         // (B3)

  double tolerance_;
};

}  // namespace tiltfeed
