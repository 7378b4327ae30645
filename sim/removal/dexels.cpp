#include "sim/removal/dexels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "sim/removal/dexel_units.h"
#include "sim/removal/sheet.h"

namespace tiltfeed::sim {
namespace {

// The bounds of a tile are made anew after so many cuts in it: they stay safe meanwhile, only wider.
constexpr int kStaleCuts = 8;
int cells(double from, double to, double cell) {
  return std::max(1, static_cast<int>(std::ceil((to - from) / cell - 1e-9)));
}

}  // namespace

Dexels::Dexels(int axis, const pathgen::Box& box, double cell)
    : axis_(axis), axis_u_((axis + 1) % 3), axis_v_((axis + 2) % 3), cell_(cell), per_mm_(1.0 / cell) {
  low_u_ = component(box.min, axis_u_), low_v_ = component(box.min, axis_v_);
  lines_u_ = cells(low_u_, component(box.max, axis_u_), cell);
  lines_v_ = cells(low_v_, component(box.max, axis_v_), cell);
  tiles_u_ = (lines_u_ + kTile - 1) / kTile;
  stripes_.resize(kStripes);
  // Whole rows of tiles, as evenly as they go.
  rows_ = (lines_v_ + kTile - 1) / kTile;
  for (int i = 0; i < kStripes; ++i) {
    Stripe& s = stripes_[i];
    s.first = std::min(lines_v_, rows_ * i / kStripes * kTile);
    s.last = std::min(lines_v_, rows_ * (i + 1) / kStripes * kTile);
    s.nodes.resize(static_cast<std::size_t>(s.last - s.first) * lines_u_);
    s.tiles.resize(static_cast<std::size_t>((s.last - s.first + kTile - 1) / kTile) * tiles_u_);
    s.stale.resize(s.tiles.size());
  }
}

std::uint64_t Dexels::line_count(int axis, const pathgen::Box& box, double cell) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  return static_cast<std::uint64_t>((component(box.max, u) - component(box.min, u)) / cell + 1.0) *
         static_cast<std::uint64_t>((component(box.max, v) - component(box.min, v)) / cell + 1.0);
}

Point<Part> Dexels::origin(int u, int v) const {
  std::array<double, 3> p{};
  p[axis_u_] = low_u_ + (u + 0.5) * cell_, p[axis_v_] = low_v_ + (v + 0.5) * cell_;
  return {p[0], p[1], p[2]};
}

Dexels::Range Dexels::range(Vec3 low, Vec3 high, int first_row, int end_row) const {
  // Whole numbers not below and not above; the library's ceil and floor are calls.
  const auto floor = [](double x) {
    const double near = std::clamp(x, -1e9, 1e9);
    const int whole = static_cast<int>(near);
    return near < whole ? whole - 1 : whole;
  };
  const auto first = [&](double at, double from) { return -floor(0.5 - (at - from) * per_mm_); };
  const auto last = [&](double at, double from) { return floor((at - from) * per_mm_ - 0.5); };
  return {std::max(first(component(low, axis_u_), low_u_), 0),
          std::min(last(component(high, axis_u_), low_u_), lines_u_ - 1),
          std::max(first(component(low, axis_v_), low_v_), first_row),
          std::min(last(component(high, axis_v_), low_v_), end_row - 1)};
}

void Dexels::add(Stripe& s, std::uint32_t line, Piece piece) {
  if (piece.low >= piece.high) return;
  if (s.nodes[line].piece.low >= s.nodes[line].piece.high) {
    s.nodes[line].piece = piece;
    return;
  }
  if (Piece& only = s.nodes[line].piece;
      s.nodes[line].next == kNone && piece.low <= only.high && piece.high >= only.low) {
    only = {std::min(only.low, piece.low), std::max(only.high, piece.high)};
    return;
  }
  // Pieces that the new one touches become part of it.
  std::vector<Piece> kept;
  for (std::uint32_t at = line; at != kNone; at = s.nodes[at].next) {
    const Piece old = s.nodes[at].piece;
    if (old.low <= piece.low && old.high >= piece.high) return;
    if (old.high < piece.low || old.low > piece.high)
      kept.push_back(old);
    else
      piece = {std::min(old.low, piece.low), std::max(old.high, piece.high)};
  }
  kept.insert(std::upper_bound(kept.begin(), kept.end(), piece,
                               [](const Piece& a, const Piece& b) { return a.low < b.low; }),
              piece);
  std::uint32_t at = line;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    s.nodes[at].piece = kept[i];
    if (i + 1 == kept.size()) break;
    if (s.nodes[at].next == kNone) {
      const auto fresh = static_cast<std::uint32_t>(s.nodes.size());
      s.nodes.emplace_back();
      s.nodes[at].next = fresh;
    }
    at = s.nodes[at].next;
  }
  s.nodes[at].next = kNone;
}

std::int64_t Dexels::remove(Stripe& s, std::uint32_t line, Piece cut, Piece& longest,
                            const Point<Part>& origin, std::vector<Removed>* gone_pieces) {
  std::int64_t removed = 0;
  std::uint32_t before = kNone;
  for (std::uint32_t at = line; at != kNone;) {
    Piece& piece = s.nodes[at].piece;
    if (piece.low >= cut.high && piece.low < piece.high) break;
    const Piece gone{std::max(piece.low, cut.low), std::min(piece.high, cut.high)};
    if (gone.low >= gone.high) {
      before = at, at = s.nodes[at].next;
      continue;
    }
    removed += gone.high - gone.low;
    if (gone_pieces != nullptr) gone_pieces->push_back({origin, gone.low * kUnit, gone.high * kUnit});
    if (gone.high - gone.low > longest.high - longest.low) longest = gone;
    if (gone.low > piece.low && gone.high < piece.high) {  // in two
      const Piece above{gone.high, piece.high};
      piece.high = gone.low;
      std::uint32_t fresh = s.spare;
      if (fresh == kNone)
        fresh = static_cast<std::uint32_t>(s.nodes.size()), s.nodes.emplace_back();
      else
        s.spare = s.nodes[fresh].next;
      s.nodes[fresh] = {above, s.nodes[at].next};
      s.nodes[at].next = fresh;
      break;
    }
    if (gone.low > piece.low) {
      piece.high = gone.low;
    } else if (gone.high < piece.high) {
      piece.low = gone.high;
    } else {  // all of it: the line's first node takes the next one's place, others leave the chain
      const std::uint32_t next = s.nodes[at].next, freed = before == kNone ? next : at;
      if (before == kNone)
        s.nodes[at] = next == kNone ? Node{} : s.nodes[next];
      else
        s.nodes[before].next = next;
      if (freed != kNone) s.nodes[freed] = {{}, s.spare}, s.spare = freed;
      if (before != kNone) at = next;
      if (before == kNone && next == kNone) break;
      continue;
    }
    before = at, at = s.nodes[at].next;
  }
  return removed;
}

bool Dexels::meets_tile(const Range& r, int tile_v, const Stripe& s, Piece along) const {
  for (int tu = r.u0 / kTile; tu <= r.u1 / kTile; ++tu) {
    const Piece& tile = s.tiles[static_cast<std::size_t>(tile_v - s.first / kTile) * tiles_u_ + tu];
    // Another thread may narrow it meanwhile: of both ends the old and the new are bounds.
    const auto end = [](const std::int32_t& value) {
      return std::atomic_ref<std::int32_t>(const_cast<std::int32_t&>(value)).load(std::memory_order_relaxed);
    };
    if (end(tile.low) < along.high && end(tile.high) > along.low) return true;
  }
  return false;
}

std::pair<int, int> Dexels::stripes(const SweptBody& body) const {
  const Range r = range(body.low, body.high);
  if (r.u0 > r.u1 || r.v0 > r.v1) return {0, 0};
  const Piece along{to_units(component(body.low, axis_)), to_units(component(body.high, axis_))};
  int at = r.v0 / kTile * kStripes / rows_, first = kStripes, last = 0;
  for (int tv = r.v0 / kTile; tv <= r.v1 / kTile; ++tv) {
    while (stripes_[at].last <= tv * kTile) ++at;
    if (last != at + 1 && meets_tile(r, tv, stripes_[at], along)) first = std::min(first, at), last = at + 1;
  }
  return {std::min(first, last), last};
}

/// The least height at which a round body can be over lines within a tile's half diagonal of its middle:
/// beside its core, at x, a ball of radius R has risen by R - sqrt(R^2 - x^2), at least x^2 / 2 R. `shadow`:
/// of the core, across the lines.
double Dexels::lowest(const SweptBody& body, const Sheet& shadow, int tile_u, int tile_v) const {
  const auto middle = [&](double low, int tile) { return low + (tile * kTile + 0.5 * kTile) * cell_; };
  std::array<double, 3> p{};
  p[axis_u_] = middle(low_u_, tile_u), p[axis_v_] = middle(low_v_, tile_v);
  const double half = std::sqrt(0.5) * (kTile - 1) * cell_;
  const double beside = std::max(0.0, tiltfeed::length(shadow.to({p[0], p[1], p[2]})) - half);
  if (beside >= body.radius) return kInfinity;
  const double foot = component(body.foot, axis_), along = component(body.along, axis_),
               way = component(body.way, axis_);
  const double core = foot + std::min(0.0, along) + std::min(0.0, way);
  return std::max(component(body.low, axis_), core - body.radius + beside * beside / (2.0 * body.radius));
}

Cut Dexels::cut(int stripe, const SweptBody& body, bool measure, std::vector<Removed>* gone) {
  Stripe& s = stripes_[stripe];
  Cut result;
  const Range r = range(body.low, body.high, s);
  if (r.u0 > r.u1 || r.v0 > r.v1) return result;
  const double low = component(body.low, axis_), high = component(body.high, axis_);
  const std::int32_t unit_low = to_units(low), unit_high = to_units(high);
  std::optional<LineCutter> made;
  // Worth it for tiles that are smaller than the body.
  std::optional<Sheet> shadow;
  if (body.solid == nullptr && kTile * cell_ < body.radius)
    shadow.emplace(across(body.foot), across(body.way), across(body.along));
  for (int tv = r.v0 / kTile; tv <= r.v1 / kTile; ++tv) {
    for (int tu = r.u0 / kTile; tu <= r.u1 / kTile; ++tu) {
      const std::size_t tile = static_cast<std::size_t>(tv - s.first / kTile) * tiles_u_ + tu;
      if (s.tiles[tile].low >= unit_high || s.tiles[tile].high <= unit_low) continue;
      if (shadow && lowest(body, *shadow, tu, tv) >= s.tiles[tile].high * kUnit) continue;
      if (!made)
        made.emplace(body, Vec3{axis_ == 0 ? 1.0 : 0.0, axis_ == 1 ? 1.0 : 0.0, axis_ == 2 ? 1.0 : 0.0});
      const LineCutter& cutter = *made;
      std::int64_t removed = 0;
      const int u0 = std::max(r.u0, tu * kTile), u1 = std::min(r.u1, tu * kTile + kTile - 1);
      for (int v = std::max(r.v0, tv * kTile); v <= std::min(r.v1, tv * kTile + kTile - 1); ++v) {
        const double pv = low_v_ + (v + 0.5) * cell_;
        for (int u = u0; u <= u1; ++u) {
          const auto line = static_cast<std::uint32_t>((v - s.first) * lines_u_ + u);
          const Node& first = s.nodes[line];
          if (first.piece.low >= unit_high || (first.next == kNone && first.piece.high <= unit_low)) continue;
          if (first.piece.low >= first.piece.high) continue;
          const double pu = low_u_ + (u + 0.5) * cell_;
          const Point<Part> foot = axis_ == 2   ? Point<Part>{pu, pv, 0.0}
                                   : axis_ == 1 ? Point<Part>{pv, 0.0, pu}
                                                : Point<Part>{0.0, pu, pv};
          const auto inside = cutter(foot, std::max(low, first.piece.low * kUnit),
                                     first.next == kNone ? std::min(high, first.piece.high * kUnit) : high);
          if (!inside) continue;
          Piece longest;
          removed += remove(s, line, {to_units(inside->enter), to_units(inside->leave)}, longest, foot, gone);
          if (!measure || longest.low >= longest.high) continue;
          std::array<double, 3> p{foot.x, foot.y, foot.z};
          p[axis_] = 0.5 * kUnit * (static_cast<double>(longest.low) + longest.high);
          const Point<Part> place{p[0], p[1], p[2]};
          if (const double depth = body.depth(place); depth > result.deepest)
            result.deepest = depth, result.place = place;
        }
      }
      result.removed += removed;
      if (removed > 0 && ++s.stale[tile] >= kStaleCuts) bound_tile(s, tu, tv);
    }
  }
  return result;
}

void Dexels::bound_tile(Stripe& s, int tu, int tv) const {
  const std::size_t tile = static_cast<std::size_t>(tv - s.first / kTile) * tiles_u_ + tu;
  Piece bounds{kHighest, kLowest};
  for (int v = tv * kTile; v < std::min(s.last, tv * kTile + kTile); ++v)
    for (int u = tu * kTile; u < std::min(lines_u_, tu * kTile + kTile); ++u)
      for (auto at = static_cast<std::uint32_t>((v - s.first) * lines_u_ + u); at != kNone;
           at = s.nodes[at].next) {
        const Piece piece = s.nodes[at].piece;
        if (piece.low < piece.high)
          bounds = {std::min(bounds.low, piece.low), std::max(bounds.high, piece.high)};
      }
  std::atomic_ref<std::int32_t>(s.tiles[tile].low).store(bounds.low, std::memory_order_relaxed);
  std::atomic_ref<std::int32_t>(s.tiles[tile].high).store(bounds.high, std::memory_order_relaxed);
  s.stale[tile] = 0;
}

void Dexels::settle(int stripe) {
  Stripe& s = stripes_[stripe];
  for (int tv = s.first / kTile; tv * kTile < s.last; ++tv)
    for (int tu = 0; tu < tiles_u_; ++tu) bound_tile(s, tu, tv);
}

std::int64_t Dexels::length(int stripe) const {
  std::int64_t sum = 0;
  each_line(stripe, [&](std::uint32_t line, int, int) {
    for (std::uint32_t at = line; at != kNone; at = node(stripe, at).next)
      sum += node(stripe, at).piece.high - node(stripe, at).piece.low;
  });
  return sum;
}

double Dexels::volume() const {
  std::int64_t sum = 0;
  for (int i = 0; i < kStripes; ++i) sum += length(i);
  return static_cast<double>(sum) * kUnit * cell_ * cell_;
}

std::size_t Dexels::bytes() const {
  std::size_t sum = 0;
  for (const Stripe& s : stripes_)
    sum += s.nodes.capacity() * sizeof(Node) + s.tiles.capacity() * (sizeof(Piece) + 1);
  return sum;
}

}  // namespace tiltfeed::sim
