#pragma once
// Cells of joint space, each asked once which pairs of bodies are clear wherever the axes stand in it. Moves
// go through the cells; memory grows with the room that they fill, not with their number. Formula (CO4) is in
// sim/collision/README.md.

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>

#include "sim/collision/collision_scene.h"

namespace tiltfeed::sim {

/// Pairs, a bit each.
using PairSet = std::uint64_t;

struct JointBox {
  AxisWords low{}, high{};
  AxisWords middle() const;
  AxisWords half() const;
  bool holds(const AxisWords& words) const;
};

/// A straight piece of a move: from..to, and the share of them that is meant.
struct JointPiece {
  AxisWords from{}, to{};
  double begin = 0.0, end = 1.0;
  AxisWords at(double share) const;
};

class JointCells {
 public:
  /// A cell in which contact points move no further than this, mm, is not divided: pieces go one by one.
  static constexpr double kFinest = 0.5;
  /// From so many cells on pieces go one by one, too.
  static constexpr std::size_t kMostCells = 4'000'000;

  /// Of moves of one kind, as `rapid` says. `scene` outlives it.
  JointCells(const CollisionScene& scene, const JointBox& root, bool rapid);
  ~JointCells();
  JointCells(const JointCells&) = delete;
  JointCells& operator=(const JointCells&) = delete;

  /// Calls rest(pairs, piece) with what no cell clears; pairs not `wanted` are left out. `clear`: a cell that
  /// was clear, from the call before. Thread-safe, with a `clear` of each thread's own.
  void walk(const JointPiece& piece, PairSet wanted, JointBox& clear,
            const std::function<void(PairSet, const JointPiece&)>& rest);
  std::size_t count() const { return count_; }

 private:
  struct Cell;
  void walk(Cell& cell, const JointBox& box, PairSet open, const JointPiece& piece, PairSet wanted,
            JointBox& clear, const std::function<void(PairSet, const JointPiece&)>& rest);
  void ask(Cell& cell, const JointBox& box, PairSet open);

  const CollisionScene& scene_;
  const JointBox root_;
  const bool rapid_;
  std::unique_ptr<Cell> top_;
  std::atomic<std::size_t> count_{1};
  std::array<std::mutex, 64> locks_;
};

}  // namespace tiltfeed::sim
