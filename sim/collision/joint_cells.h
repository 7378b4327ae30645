#pragma once
// Cells of joint space, for each pair of bodies of its own, each asked once whether the pair is clear
// wherever the axes stand in it. Moves go through the cells; memory grows with the room that they fill, not
// with their number. Formula (CO4) is in sim/collision/README.md.

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>

#include "sim/collision/collision_scene.h"

namespace tiltfeed::sim {

struct JointBox {
  AxisWords low{}, high{};
  AxisWords middle() const;
  AxisWords half() const;
  bool holds(const AxisWords& words) const;
  /// To what `other` holds, too.
  void cut(const JointBox& other);
  static JointBox none();
  static JointBox everything();
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

  /// What of a piece its pair's cells do not clear.
  using Rest = std::function<void(const JointPiece&)>;
  /// Calls rest(piece). `clear`: becomes the last cell that was clear for the pair. Thread-safe.
  void walk(std::size_t pair, const JointPiece& piece, JointBox& clear, const Rest& rest);
  std::size_t count() const { return count_; }

 private:
  struct Cell;
  void walk(const BodyPair& pair, Cell& cell, const JointBox& box, const JointPiece& piece, JointBox& clear,
            const Rest& rest);
  void ask(const BodyPair& pair, Cell& cell, const JointBox& box) const;

  const CollisionScene& scene_;
  const JointBox root_;
  const bool rapid_;
  std::unique_ptr<Cell[]> tops_;  ///< one for each pair
  std::atomic<std::size_t> count_;
  std::array<std::mutex, 64> locks_;
};

}  // namespace tiltfeed::sim
