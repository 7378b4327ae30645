#pragma once
// The parts of a removal run: moves to bodies, bodies' findings over time, findings to places.

#include <optional>
#include <utility>
#include <vector>

#include "config/job.h"
#include "sim/removal/contact.h"
#include "sim/removal/occupied.h"
#include "sim/removal/removal_result.h"
#include "sim/removal/stock.h"

namespace tiltfeed::sim {

/// Something wrong at one move.
struct MoveHit {
  TroubleKind kind = TroubleKind::kGouge;
  ToolPart tool = ToolPart::kCutter;
  std::uint32_t move = 0;
  double depth = 0.0;
  std::uint32_t facet = kNoFacet;  ///< of the STL file
  Point<Part> place;
};

/// What a part of the tool sweeps in some moves in a row.
struct SweptPiece {
  std::uint32_t first_move = 0, moves = 1;
  SweptBody body;
};
/// What some moves sweep, and what they do to the part.
struct Swept {
  std::vector<SweptPiece> pieces;  ///< near stock only, in order
  /// Which of them meet stripe s of bundle b: by b * Dexels::kStripes + s.
  std::vector<std::vector<std::uint32_t>> by_stripe;
  std::vector<MoveHit> hits;
  std::array<MoveHit, 2> worst;  ///< deepest gouge and rapid in the part, tolerated ones too; or depth 0
  Haste haste;
  std::vector<double> ways;  ///< of the tip on the part, by move, mm
};

/// Poses of the moves: (W4) as many straight steps as keep the tool near where the axes put it.
class Stand {
 public:
  Stand(const config::Job& job, const ExecutedPath& path, const Stock& stock, Probes& probes,
        const RemovalOptions& options);

  /// Bodies of the moves [begin, end); what they do to the part.
  void sweep_moves(std::size_t begin, std::size_t end, Swept& out) const;
  const Contact& contact() const { return contact_; }
  /// A finding if the tool stands inside of the part before the first move.
  std::optional<MoveHit> starts_inside() const;

 private:
  void add_steps(std::size_t move, const Pose& from, std::vector<SweptStep>& steps) const;
  double turn_pieces(const Pose& from, const Pose& to) const;
  void time(std::size_t move, double way, Point<Part> place, Haste& haste) const;
  void sweep_stock(const std::vector<SweptStep>& steps, Swept& out) const;
  std::size_t run_end(const std::vector<SweptStep>& steps, std::size_t begin) const;
  void share_out(std::uint32_t first_move, std::uint32_t moves, const std::vector<SweptBody>& bodies,
                 Swept& out) const;

  const ExecutedPath& path_;
  const Stock& stock_;
  const Probes& probes_;
  FrameChain chain_;
  ToolSolid solid_;
  ToolSweep sweep_;
  Contact contact_;
  Occupied occupied_;
  double tolerance_, top_, least_, cell_;
  double feed_;  ///< the largest of the job, mm/min
  bool stock_alone_;
};

/// What happens when.
class Timeline {
 public:
  Timeline(const ExecutedPath& path, double diameter, double cell);
  /// What a move removed, mm^3, and the way of its tip on the part, mm. Requires: moves in order.
  void add(std::size_t move, double removed, double way);
  void finish(Removal& result);

 private:
  void end_stretch();
  void move_axes(std::size_t move);
  std::size_t bin(double time) const;

  const ExecutedPath& path_;
  double begin_, width_, window_;
  std::vector<TimeBin> bins_;
  // A stretch of feed moves: all of it is air if it removes nothing.
  double stretch_removed_ = 0.0, stretch_way_ = 0.0, stretch_seconds_ = 0.0;
  std::size_t stretch_begin_ = 0, stretch_end_ = 0;
  double feed_seconds_ = 0.0, rapid_seconds_ = 0.0, air_seconds_ = 0.0;
  double feed_length_ = 0.0, rapid_length_ = 0.0;
  std::array<double, 5> travel_low_, travel_high_;
};

/// Percentiles and the map of what is left; probes deeper than the tolerance become hits where none is yet.
void measure_excess(const Probes& probes, const Contact& contact, const RemovalOptions& options,
                    const ExecutedPath& path, Removal& result, std::vector<MoveHit>& hits);
/// The places where most is left, `apart` mm or more from each other. Requires: measure_excess().
std::vector<Leftover> most_left(const Probes& probes, const ExecutedPath& path, const Removal& result,
                                double apart);
/// Runs of hits as troubles.
std::vector<Trouble> gather(const ExecutedPath& path, std::vector<MoveHit> hits);

}  // namespace tiltfeed::sim
