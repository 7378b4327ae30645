// Inside a cell of the grid: which crossings belong together. (Z2) in pathgen/pattern/README.md.

#include <algorithm>
#include <cmath>

#include "pathgen/pattern/level_set.h"

namespace tiltfeed::pathgen {

namespace {

/// Cells with more than two crossings are halved this often before the middle decides: to 1 / 64 of the grid.
constexpr int kMostCellHalvings = 6;
/// Places looked at on a straight line to tell whether it stays on one side of the level.
constexpr int kLookPlaces = 12;

}  // namespace

LevelSet::Ring LevelSet::ring_of(const Cell& cell) const {
  Ring ring;
  for (int s = 0; s < 4; ++s) {
    const Side& side = cell.sides[static_cast<std::size_t>(s)];
    const std::size_t n = side.crossings.size();
    for (std::size_t k = 0; k < n; ++k) {
      const bool back = s >= 2;
      ring.crossings.push_back(side.crossings[back ? n - 1 - k : k]);
      ring.after.push_back(side.pieces[back ? n - 1 - k : k + 1]);
      ring.side.push_back(s);
    }
  }
  return ring;
}

void LevelSet::resolve(const Cell& cell, int depth) {
  const Ring ring = ring_of(cell);
  const std::size_t n = ring.crossings.size();
  if (n == 0) return;
  if (n == 2) return link_all(ring, true);
  if (n == 4) {
    if (connected(cell, ring, true)) return link_all(ring, true);
    if (connected(cell, ring, false)) return link_all(ring, false);
  }
  if (depth < kMostCellHalvings) return split(cell, depth);
  link_all(ring, heights_.is_over({(cell.x0 + cell.x1) / 2.0, (cell.y0 + cell.y1) / 2.0}, level_));
}

void LevelSet::link(const Ring& ring, std::size_t exit, std::size_t entry) {
  const std::size_t n = ring.crossings.size();
  const auto before = [&](std::size_t k) { return ring.after[(k + n - 1) % n]; };
  const auto a = static_cast<std::size_t>(ring.crossings[exit]),
             b = static_cast<std::size_t>(ring.crossings[entry]);
  next_[a] = static_cast<int>(b);
  unite(before(exit), ring.after[entry]);
  unite(ring.after[exit], before(entry));
  beside_[a] = {before(exit), ring.after[exit]};
  beside_[b] = {ring.after[entry], before(entry)};
}

/// Cuts off each piece of the other state by itself, so that what is higher, or what is lower, stays in one.
void LevelSet::link_all(const Ring& ring, bool inside_connected) {
  const std::size_t n = ring.crossings.size();
  for (std::size_t k = 0; k < n; ++k) {
    if (inside_[static_cast<std::size_t>(ring.after[k])])
      continue;  // k is where the border leaves the inside
    link(ring, k, inside_connected ? (k + 1) % n : (k + n - 1) % n);
  }
}

Place LevelSet::place_of(const Cell& cell, const Ring& ring, std::size_t arc) const {
  const auto on_side = [&](std::size_t k) {
    const Crossing& c = crossings_[static_cast<std::size_t>(ring.crossings[k])];
    Place p = lerp(c.outside, c.inside, 0.5);
    if (ring.side[k] == 0) p.y = cell.y0;
    if (ring.side[k] == 1) p.x = cell.x1;
    if (ring.side[k] == 2) p.y = cell.y1;
    if (ring.side[k] == 3) p.x = cell.x0;
    return p;
  };
  if (arc + 1 < ring.side.size() && ring.side[arc] == ring.side[arc + 1])
    return lerp(on_side(arc), on_side(arc + 1), 0.5);
  switch (ring.side[arc]) {  // round the corner at the side's end
    case 0:
      return {cell.x1, cell.y0};
    case 1:
      return {cell.x1, cell.y1};
    case 2:
      return {cell.x0, cell.y1};
    default:
      return {cell.x0, cell.y0};
  }
}

/// Of four crossings: is there a straight way between the two pieces of one state?
bool LevelSet::connected(const Cell& cell, const Ring& ring, bool inside) {
  const std::size_t first = inside_[static_cast<std::size_t>(ring.after[0])] == inside ? 0 : 1;
  const Place a = place_of(cell, ring, first), b = place_of(cell, ring, first + 2);
  for (int k = 1; k < kLookPlaces; ++k)
    if (heights_.is_over(lerp(a, b, static_cast<double>(k) / kLookPlaces), level_) != inside) return false;
  return true;
}

/// A grid line inside a cell.
LevelSet::Side LevelSet::inner_side(Place from, Place to, int low, int high) {
  const FlatLine line = line_between(from, to);
  const bool in_low = inside_[static_cast<std::size_t>(low)],
             in_high = inside_[static_cast<std::size_t>(high)];
  std::size_t next = 0;
  const std::vector<Crossing> found =
      cross_edge(heights_.profile(line, level_), line, next, 0.0, line.length, in_low, in_high);
  Side side;
  side.pieces.push_back(low);
  for (std::size_t c = 0; c < found.size(); ++c) {
    side.crossings.push_back(static_cast<int>(crossings_.size()));
    crossings_.push_back(found[c]);
    beside_.push_back({-1, -1}), next_.push_back(-1);
    side.pieces.push_back(c + 1 < found.size() ? new_piece((c % 2 == 0) != in_low) : high);
  }
  if (found.empty()) unite(low, high);
  return side;
}

void LevelSet::split(const Cell& cell, int depth) {
  const double x = (cell.x0 + cell.x1) / 2.0, y = (cell.y0 + cell.y1) / 2.0;
  // Each side in two halves that share the piece in the middle.
  std::array<std::array<Side, 2>, 4> half;
  std::array<int, 4> middle{};
  for (std::size_t s = 0; s < 4; ++s) {
    const Side& whole = cell.sides[s];
    const bool level_side = s == 0 || s == 2;
    std::size_t k = 0;
    for (; k < whole.crossings.size(); ++k) {
      const Crossing& c = crossings_[static_cast<std::size_t>(whole.crossings[k])];
      const Place p = lerp(c.outside, c.inside, 0.5);
      if ((level_side ? p.x : p.y) >= (level_side ? x : y)) break;
    }
    const auto crossings = whole.crossings.begin(), pieces = whole.pieces.begin();
    const auto at = static_cast<std::ptrdiff_t>(k);
    half[s][0] = {{crossings, crossings + at}, {pieces, pieces + at + 1}};
    half[s][1] = {{crossings + at, whole.crossings.end()}, {pieces + at, whole.pieces.end()}};
    middle[s] = whole.pieces[k];
  }
  const int centre = new_piece(heights_.is_over({x, y}, level_));
  const Side down = inner_side({x, cell.y0}, {x, y}, middle[0], centre),
             up = inner_side({x, y}, {x, cell.y1}, centre, middle[2]),
             left = inner_side({cell.x0, y}, {x, y}, middle[3], centre),
             right = inner_side({x, y}, {cell.x1, y}, centre, middle[1]);
  resolve({cell.x0, cell.y0, x, y, {half[0][0], down, left, half[3][0]}}, depth + 1);
  resolve({x, cell.y0, cell.x1, y, {half[0][1], half[1][0], right, down}}, depth + 1);
  resolve({x, y, cell.x1, cell.y1, {right, half[1][1], half[2][1], up}}, depth + 1);
  resolve({cell.x0, y, x, cell.y1, {left, up, half[2][0], half[3][1]}}, depth + 1);
}

}  // namespace tiltfeed::pathgen
