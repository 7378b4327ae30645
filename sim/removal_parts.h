#pragma once
// The parts of a removal run: moves to bodies, bodies' findings over time, findings to places.

#include <optional>
#include <utility>
#include <vector>

#include "sim/removal.h"
#include "sim/tool_sweep.h"

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
/// A straight step of a move.
struct SweptStep {
  std::uint32_t move = 0;
  Pose from, to;
};
/// What some moves sweep, and what they do to the part.
struct Swept {
  std::vector<SweptPiece> pieces;  ///< near stock only, in order
  /// Which of them meet stripe s of bundle b: by b * Dexels::kStripes + s.
  std::vector<std::vector<std::uint32_t>> by_stripe;
  std::vector<MoveHit> hits;
  std::array<double, 4> worst{};  ///< by TroubleKind, mm
  double feed_length = 0.0, rapid_length = 0.0;
};

/// Where stock is near at the start, in coarse cubes.
class Occupied {
 public:
  /// Cubes within `reach` of stock count.
  Occupied(const Stock& stock, double reach);
  bool near(Point<Part> p) const;

 private:
  std::array<int, 3> index(Vec3 p) const;
  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * size_[1] + y) * size_[0] + x;
  }
  void widen(int axis, int by);
  Vec3 origin_, end_;
  double cube_;
  std::array<int, 3> size_{};
  std::vector<char> full_;
};

/// Poses of the moves: (R4) as many straight steps as keep the tool within kStray of where the axes put it.
class Stand {
 public:
  Stand(const Job& job, const ExecutedPath& path, const Stock& stock, Probes& probes,
        const RemovalOptions& options);

  const ToolSweep& sweep() const { return sweep_; }
  /// Bodies of the moves [begin, end); exact distances to the part at the steps' ends and between; probes.
  void sweep_moves(std::size_t begin, std::size_t end, Swept& out) const;
  /// The cutting part's axis at the middle of a step, and how far from it the cutting part comes.
  std::pair<Segment, double> core(const SweptStep& step) const;
  /// Not more than the distance from p to what the cutting part sweeps, mm.
  double nearest(const SweptStep& step, Point<Part> p) const;
  /// A finding if the tool stands inside of the part before the first move.
  std::optional<MoveHit> starts_inside() const;

 private:
  Pose pose(const Joints& joints) const;
  int steps(const Pose& from, const Pose& middle, const Pose& to) const;
  /// What a thread works with.
  struct Bench {
    std::vector<SweptBody> bodies;
    std::vector<std::uint32_t> near;
    std::vector<Pose> looks;
  };
  void share_out(const SweptStep& step, Bench& bench, Swept& out) const;
  void look(const SweptStep& step, Bench& bench, Swept& out) const;
  Hit clearance(const Pose& pose, ToolPart part, const std::vector<std::uint32_t>& near, double bound) const;

  const Job& job_;
  const ExecutedPath& path_;
  const Stock& stock_;
  Probes& probes_;
  ToolSolid solid_;
  ToolSweep sweep_;
  Occupied occupied_;
  bool plain_;  ///< a ball end mill with a shank of its own diameter and nothing above
  double tolerance_, top_, least_, cell_;
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
void measure_excess(const Probes& probes, const RemovalOptions& options, const ExecutedPath& path,
                    Removal& result, std::vector<MoveHit>& hits);
/// Runs of hits as troubles.
std::vector<Trouble> gather(const ExecutedPath& path, std::vector<MoveHit> hits);

}  // namespace tiltfeed::sim
