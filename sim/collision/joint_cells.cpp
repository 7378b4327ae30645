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

JointBox JointBox::none() {
  JointBox box;
  box.low.fill(1.0), box.high.fill(-1.0);
  return box;
}

JointBox JointBox::everything() {
  JointBox box;
  box.low.fill(-kInfinity), box.high.fill(kInfinity);
  return box;
}

void JointBox::cut(const JointBox& other) {
  for (std::size_t i = 0; i < low.size(); ++i) {
    low[i] = std::max(low[i], other.low[i]);
    high[i] = std::min(high[i], other.high[i]);
  }
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
  bool clear = false, finest = false;
  std::uint8_t axis = 0;  ///< that it is halved along

  Cell() = default;
  ~Cell() { delete[] halves.load(); }
  Cell(const Cell&) = delete;
  Cell& operator=(const Cell&) = delete;
};

JointCells::JointCells(const CollisionScene& scene, const JointBox& root, bool rapid)
    : scene_(scene),
      root_(root),
      rapid_(rapid),
      tops_(std::make_unique<Cell[]>(scene.pairs().size())),
      count_(scene.pairs().size()) {}

JointCells::~JointCells() = default;

/// (CO4) Clear at the middle by more than what moves between it and anywhere in the cell: clear everywhere.
void JointCells::ask(const BodyPair& pair, Cell& cell, const JointBox& box) const {
  const AxisWords half = box.half();
  const double motion = pair.motion(half);
  cell.clear = !scene_.nearer(pair, box.middle(), pair.asked(rapid_) + motion, kCellSlack * motion,
                              motion > kCoarse ? kPatience : 0);
  cell.finest = motion < kFinest;
  double most = 0.0;
  for (std::size_t axis = 0; axis < half.size(); ++axis) {
    AxisWords one{};
    one[axis] = half[axis];
    if (const double by = pair.motion(one); by > most) most = by, cell.axis = static_cast<std::uint8_t>(axis);
  }
}

void JointCells::walk(std::size_t pair, const JointPiece& piece, JointBox& clear, const Rest& rest) {
  if (!root_.holds(piece.from) || !root_.holds(piece.to)) return rest(piece);
  walk(scene_.pairs()[pair], tops_[pair], root_, piece, clear, rest);
}

void JointCells::walk(const BodyPair& pair, Cell& cell, const JointBox& box, const JointPiece& piece,
                      JointBox& clear, const Rest& rest) {
  std::mutex& lock = locks_[(reinterpret_cast<std::uintptr_t>(&cell) / sizeof(Cell)) % locks_.size()];
  if (!cell.asked.load(std::memory_order_acquire)) {
    const std::lock_guard guard(lock);
    if (!cell.asked.load(std::memory_order_relaxed)) {
      ask(pair, cell, box);
      cell.asked.store(true, std::memory_order_release);
    }
  }
  if (cell.clear) {
    clear = box;
    return;
  }
  Cell* halves = cell.halves.load(std::memory_order_acquire);
  if (cell.finest || (halves == nullptr && count_ >= kMostCells)) return rest(piece);
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
    walk(pair, halves[up ? 1 : 0], up ? upper : lower, part, clear, rest);
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
