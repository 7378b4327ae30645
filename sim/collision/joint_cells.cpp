#include "sim/collision/joint_cells.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tiltfeed::sim {
namespace {

// Of a cell's motion: bodies that are further apart than asked by this are taken for near, which spares tests
// of single facets.
constexpr double kCellSlack = 0.1;
// Where contact points move further than this, mm, a question that takes more than so many pairs of boxes is
// cheaper answered by the halves.
constexpr double kCoarse = 2.0;
constexpr std::uint32_t kPatience = 400;

}  // namespace

AxisWords JointBox::middle() const {
  AxisWords m;
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = 0.5 * (low[i] + high[i]);
  return m;
}

AxisWords JointBox::half() const {
  AxisWords h;
  for (std::size_t i = 0; i < h.size(); ++i) h[i] = 0.5 * (high[i] - low[i]);
  return h;
}

bool JointBox::holds(const AxisWords& words) const {
  for (std::size_t i = 0; i < words.size(); ++i)
    if (words[i] < low[i] || words[i] > high[i]) return false;
  return true;
}

AxisWords JointPiece::at(double share) const {
  AxisWords words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = from[i] + share * (to[i] - from[i]);
  return words;
}

/// Asked when a piece first comes into it.
struct JointCells::Cell {
  std::atomic<Cell*> halves{nullptr};  ///< two
  std::atomic<bool> asked{false};
  std::uint8_t axis = 0;
  bool finest = false;
  PairSet open = 0;  ///< pairs that it does not clear

  Cell() = default;
  ~Cell() { delete[] halves.load(); }
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;
};

JointCells::JointCells(const CollisionScene& scene, const JointBox& root, bool rapid)
    : scene_(scene), root_(root), rapid_(rapid), top_(std::make_unique<Cell>()) {}

JointCells::~JointCells() = default;

/// (CO4) Clear at the middle by more than what moves between it and anywhere in the cell: clear everywhere.
void JointCells::ask(Cell& cell, const JointBox& box, PairSet open) {
  const AxisWords middle = box.middle(), half = box.half();
  AxisWords most{};  // of what each axis moves the pairs that are left
  double furthest = 0.0;
  for (std::size_t i = 0; i < scene_.pairs().size(); ++i) {
    const PairSet bit = PairSet{1} << i;
    if ((open & bit) == 0) continue;
    const BodyPair& pair = scene_.pairs()[i];
    const double motion = pair.motion(half);
    if (!scene_.nearer(pair, middle, pair.asked(rapid_) + motion, kCellSlack * motion,
                       motion > kCoarse ? kPatience : 0)) {
      open &= ~bit;
      continue;
    }
    furthest = std::max(furthest, motion);
    for (std::size_t axis = 0; axis < most.size(); ++axis) {
      AxisWords one{};
      one[axis] = half[axis];
      most[axis] = std::max(most[axis], pair.motion(one));
    }
  }
  cell.open = open;
  cell.finest = furthest < kFinest;
  cell.axis = static_cast<std::uint8_t>(std::max_element(most.begin(), most.end()) - most.begin());
}

void JointCells::walk(const JointPiece& piece, PairSet wanted, JointBox& clear,
                      const std::function<void(PairSet, const JointPiece&)>& rest) {
  if (clear.holds(piece.from) && clear.holds(piece.to)) return;
  const PairSet all = scene_.pairs().size() == CollisionScene::kMostPairs
                          ? ~PairSet{0}
                          : (PairSet{1} << scene_.pairs().size()) - 1;
  if (!root_.holds(piece.from) || !root_.holds(piece.to)) return rest(all & wanted, piece);
  walk(*top_, root_, all, piece, wanted, clear, rest);
}

void JointCells::walk(Cell& cell, const JointBox& box, PairSet open, const JointPiece& piece, PairSet wanted,
                      JointBox& clear, const std::function<void(PairSet, const JointPiece&)>& rest) {
  std::mutex& lock = locks_[(reinterpret_cast<std::uintptr_t>(&cell) / sizeof(Cell)) % locks_.size()];
  if (!cell.asked.load(std::memory_order_acquire)) {
    const std::lock_guard guard(lock);
    if (!cell.asked.load(std::memory_order_relaxed)) {
      ask(cell, box, open);
      cell.asked.store(true, std::memory_order_release);
    }
  }
  if (cell.open == 0) {
    clear = box;
    return;
  }
  if ((cell.open & wanted) == 0) return;
  Cell* halves = cell.halves.load(std::memory_order_acquire);
  if (cell.finest || (halves == nullptr && count_ >= kMostCells)) return rest(cell.open & wanted, piece);
  if (halves == nullptr) {
    const std::lock_guard guard(lock);
    halves = cell.halves.load(std::memory_order_relaxed);
    if (halves == nullptr) {
      halves = new Cell[2];
      count_ += 2;
      cell.halves.store(halves, std::memory_order_release);
    }
  }
  const std::size_t axis = cell.axis;
  const double middle = 0.5 * (box.low[axis] + box.high[axis]);
  JointBox lower = box, upper = box;
  lower.high[axis] = upper.low[axis] = middle;
  const double begin = piece.at(piece.begin)[axis], end = piece.at(piece.end)[axis];
  const auto go = [&](bool up, const JointPiece& part) {
    walk(halves[up ? 1 : 0], up ? upper : lower, cell.open, part, wanted, clear, rest);
  };
  if ((begin <= middle) == (end <= middle)) return go(begin > middle, piece);
  // Both halves get the place of the plane between them.
  const double share =
      piece.begin + (piece.end - piece.begin) * std::clamp((middle - begin) / (end - begin), 0.0, 1.0);
  JointPiece first = piece, second = piece;
  first.end = second.begin = share;
  go(begin > middle, first);
  go(end > middle, second);
}

}  // namespace tiltfeed::sim
