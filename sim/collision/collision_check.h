#pragma once
// A program's moves against collisions of machine, tool, part and fixtures, continuously along each move.
// Memory does not grow with the number of moves. Formulas (CO1)..(CO5) are in sim/collision/README.md.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/collision/joint_cells.h"
#include "sim/control/move_frames.h"

namespace tiltfeed::sim {

/// "Clear" is proven. "Collision" is nearer than the clearance and this, mm, beside what kSagitta makes of
/// each round body and, under TCP, a hundredth of a mm.
inline constexpr double kCollisionError = 0.02;
/// Of a pair so many places are told; it is not looked at after them.
inline constexpr std::size_t kMostPlaces = 20;

/// Pairs, a bit each.
using PairSet = std::uint64_t;

struct CollisionPlace {
  std::size_t pair = 0;
  bool rapid = false;
  std::uint32_t line = 0;   ///< of the text, from 1
  std::uint64_t block = 0;  ///< of those that move an axis, from 1
  AxisWords words{};        ///< of the slides and rotaries
  double apart = 0.0;       ///< mm; 0: they cross, or one is in the other
  double depth = 0.0;       ///< a corner of one is so deep in the other, mm; when it is measured
  std::string first, second;

  bool worse_than(const CollisionPlace& other) const;
};

/// Of some moves, in their order.
struct Collisions {
  std::vector<CollisionPlace> places;

  /// Adds what comes after; of a pair no more than kMostPlaces.
  void add(Collisions next);
};

class CollisionCheck {
 public:
  /// Outlived by nothing. Errors: kIo, kInput: an STL file of a body or fixture.
  static Result<CollisionCheck> make(const pathgen::CheckedMesh& part, const config::Job& job);

  bool idle() const { return scene_->pairs().empty(); }
  /// What is checked, and what is not, in a line.
  std::string scope() const;
  /// The first place of each move and pair; pairs in `told` are left out. The same moves give the same
  /// places. Thread-safe.
  Collisions hold(std::span<const ProgramMove> moves, PairSet told) const;
  /// Where the program takes over: as above, and bodies wholly in each other.
  Collisions look(const ProgramMove& place) const;
  /// How deep bodies are in each other where they cross.
  void measure(Collisions& collisions) const;
  /// Pairs of which kMostPlaces are known.
  static PairSet told(const Collisions& collisions);
  /// The first and the worst place, by line and by name.
  std::string text(const Collisions& collisions, const std::string& name) const;

 private:
  CollisionCheck(const config::Job& job, CollisionScene scene);
  struct ClearBoxes;
  void hold(const ProgramMove& move, PairSet told, ClearBoxes& clear, Collisions& found) const;
  void hold(const JointPiece& piece, const ProgramMove& move, PairSet told, ClearBoxes& clear,
            Collisions& found) const;
  bool follow(std::size_t pair, const JointPiece& piece, const ProgramMove& move, Collisions& found) const;
  CollisionPlace place(std::size_t pair, const AxisWords& words, const ProgramMove& move) const;
  bool one_in_other(const BodyPair& pair, const AxisWords& words) const;
  double depth(const BodyPair& pair, const AxisWords& words) const;
  std::string place_text(const CollisionPlace& place) const;

  MachineModel model_;
  bool has_bodies_ = false, has_fixtures_ = false;
  MoveFrames frames_;
  std::unique_ptr<CollisionScene> scene_;
  std::unique_ptr<JointCells> feed_, rapid_;
};

}  // namespace tiltfeed::sim
