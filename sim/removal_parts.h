#pragma once
// The parts of a removal run: moves to bodies, bodies' findings over time, findings to places.

#include <optional>
#include <utility>
#include <vector>

#include "sim/contact.h"
#include "sim/removal.h"

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

struct SweptPiece {
  std::uint32_t move = 0;
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
  double feed_length = 0.0, rapid_length = 0.0;
};

/// Where stock is near at the start, in coarse cubes.
class Occupied {
 public:
  /// Cubes within `reach` of stock count.
  Occupied(const Stock& stock, double reach);
  /// How far round p nothing is near, mm, or below 0: stock is.
  double clear(Point<Part> p) const;

 private:
  std::array<int, 3> index(Vec3 p) const;
  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * size_[1] + y) * size_[0] + x;
  }
  void measure();
  Vec3 origin_, end_;
  double cube_;
  std::array<int, 3> size_{};
  int by_;                            ///< cubes up to this far from stock are near
  std::vector<std::uint16_t> cubes_;  ///< how many it is to the nearest one with stock, in any direction
};

/// Poses of the moves: (R4) as many straight steps as keep the tool near where the axes put it.
class Stand {
 public:
  Stand(const Job& job, const ExecutedPath& path, const Stock& stock, Probes& probes,
        const RemovalOptions& options);

  /// Bodies of the moves [begin, end); what they do to the part.
  void sweep_moves(std::size_t begin, std::size_t end, Swept& out) const;
  const Contact& contact() const { return contact_; }
  /// A finding if the tool stands inside of the part before the first move.
  std::optional<MoveHit> starts_inside() const;

 private:
  void add_steps(std::size_t move, const Pose& from, std::vector<SweptStep>& steps) const;
  void time(std::size_t move, double way, Point<Part> place, Haste& haste) const;
  void share_out(const SweptStep& step, std::vector<SweptBody>& bodies, Swept& out) const;

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
};

/// What happens when.
class Timeline {
 public:
  Timeline(const ExecutedPath& path, double diameter, double cell);
  /// Requires: moves in order.
  void add(std::size_t move, double removed);
  void add_lengths(double feed, double rapid) { feed_length_ += feed, rapid_length_ += rapid; }
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
