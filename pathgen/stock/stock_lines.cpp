#include "pathgen/stock/stock_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tiltfeed::pathgen {

namespace {

/// Cuts of a tile until its bounds are found anew.
constexpr int kStale = 8;

int lines_over(double length, double apart) {
  return std::max(1, static_cast<int>(std::ceil(length / apart - 1e-9)));
}

}  // namespace

StockLines::StockLines(const Mesh& blank, int along, double apart) : along_(along), apart_(apart) {
  LinePlace low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (const Point<Part>& vertex : blank.vertices) {
    const LinePlace p = line_place(from_origin(vertex), along);
    low = {std::min(low.u, p.u), std::min(low.v, p.v), std::min(low.t, p.t)};
    high = {std::max(high.u, p.u), std::max(high.v, p.v), std::max(high.t, p.t)};
  }
  u_ = low.u, v_ = low.v, lowest_ = low.t, highest_ = high.t;
  nu_ = lines_over(high.u - low.u, apart), nv_ = lines_over(high.v - low.v, apart);
  rows_.resize(static_cast<std::size_t>((nv_ + kTile - 1) / kTile));
  for (Row& row : rows_) {
    row.lines.resize(static_cast<std::size_t>(nu_) * kTile);
    row.tiles.resize(static_cast<std::size_t>((nu_ + kTile - 1) / kTile));
  }
  fill(blank);
  for (std::size_t row = 0; row < rows_.size(); ++row)
    for (int tile = 0; tile < std::ssize(rows_[row].tiles); ++tile) bound(row, tile);
}

/// Each facet gives the lines that pass it an end. An edge is crossed by its lower end, so that of two
/// facets at an edge a line crosses one.
void StockLines::fill(const Mesh& blank) {
  std::vector<std::vector<double>> ends(static_cast<std::size_t>(nu_) * static_cast<std::size_t>(nv_));
  for (const auto& facet : blank.facets) {
    std::array<LinePlace, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = line_place(from_origin(blank.vertices[facet[k]]), along_);
    // The plane as t over (u, v).
    const double au = p[1].u - p[0].u, av = p[1].v - p[0].v, at = p[1].t - p[0].t;
    const double bu = p[2].u - p[0].u, bv = p[2].v - p[0].v, bt = p[2].t - p[0].t;
    const double whole = au * bv - av * bu;
    if (whole == 0.0) continue;
    const auto [v_low, v_high] = std::minmax({p[0].v, p[1].v, p[2].v});
    const auto [t_low, t_high] = std::minmax({p[0].t, p[1].t, p[2].t});
    const int first = std::max(0, static_cast<int>(std::floor((v_low - v_) / apart_ - 0.5))),
              last = std::min(nv_ - 1, static_cast<int>(std::ceil((v_high - v_) / apart_ - 0.5)));
    for (int j = first; j <= last; ++j) {
      const double v = v_ + (j + 0.5) * apart_;
      std::array<double, 2> cross{};
      std::size_t crossed = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        LinePlace a = p[k], b = p[(k + 1) % 3];
        if ((a.v <= v) == (b.v <= v) || crossed == 2) continue;
        if (a.v > b.v) std::swap(a, b);
        cross[crossed++] = a.u + (v - a.v) / (b.v - a.v) * (b.u - a.u);
      }
      if (crossed < 2) continue;
      const auto from = static_cast<int>(std::ceil((std::min(cross[0], cross[1]) - u_) / apart_ - 0.5)),
                 to = static_cast<int>(std::ceil((std::max(cross[0], cross[1]) - u_) / apart_ - 0.5));
      for (int i = std::max(0, from); i < std::min(nu_, to); ++i) {
        const double du = u_ + (i + 0.5) * apart_ - p[0].u, dv = v - p[0].v;
        const double x = (du * bv - dv * bu) / whole, y = (au * dv - av * du) / whole;
        ends[static_cast<std::size_t>(j * nu_ + i)].push_back(
            std::clamp(p[0].t + x * at + y * bt, t_low, t_high));
      }
    }
  }
  for (int j = 0; j < nv_; ++j)
    for (int i = 0; i < nu_; ++i) {
      std::vector<double>& at = ends[static_cast<std::size_t>(j * nu_ + i)];
      std::sort(at.begin(), at.end());
      Line& one = line(static_cast<std::size_t>(j / kTile), i, j % kTile);
      for (std::size_t k = 0; k + 1 < at.size(); k += 2) {
        if (at[k] >= at[k + 1]) continue;
        if (one.empty())
          one.first = {at[k], at[k + 1]};
        else
          one.above.push_back({at[k], at[k + 1]});
      }
    }
}

StockLines::Window StockLines::window(std::size_t row, const PlacedSolid& solid) const {
  const auto index = [&](double at, double from) { return (at - from) / apart_ - 0.5; };
  const double low = row_low(row);
  const auto lines = std::min(kTile, nv_ - static_cast<int>(row) * kTile);
  return {std::max(0, static_cast<int>(std::ceil(std::max(-1.0, index(solid.low().u, u_))))),
          static_cast<int>(std::floor(std::min(nu_ - 1.0, index(solid.high().u, u_)))),
          std::max(0, static_cast<int>(std::ceil(std::max(-1.0, index(solid.low().v, low))))),
          static_cast<int>(std::floor(std::min(lines - 1.0, index(solid.high().v, low))))};
}

/// Calls take(tile, line, its place, where it is in the solid) for lines whose material may be in it.
template <class Lines, class Take>
void StockLines::each_line(Lines& of, std::size_t row, const PlacedSolid& solid, const Take& take) {
  const Window w = of.window(row, solid);
  if (w.u0 > w.u1 || w.v0 > w.v1) return;
  const double low = of.row_low(row);
  for (int tile = w.u0 / kTile; tile <= w.u1 / kTile; ++tile) {
    const Tile& bounds = of.rows_[row].tiles[static_cast<std::size_t>(tile)];
    if (bounds.low > solid.high().t || bounds.high < solid.low().t || bounds.low > bounds.high) continue;
    const double from = of.u_ + tile * kTile * of.apart_, wide = kTile * of.apart_;
    if (!solid.may_meet({from, low, bounds.low}, {from + wide, low + wide, bounds.high})) continue;
    for (int v = w.v0; v <= w.v1; ++v)
      for (int u = std::max(w.u0, tile * kTile); u <= std::min(w.u1, tile * kTile + kTile - 1); ++u) {
        auto& one = of.line(row, u, v);
        if (one.empty() || one.top() <= solid.low().t || one.first.low >= solid.high().t) continue;
        const LinePlace at{of.u_ + (u + 0.5) * of.apart_, low + (v + 0.5) * of.apart_, 0.0};
        if (const auto inside = solid.on_line(at.u, at.v)) take(tile, one, at, *inside);
      }
  }
}

/// True if there was something.
bool StockLines::remove(Line& line, LineSpan gone) {
  if (line.empty() || gone.low >= line.top() || gone.high <= line.first.low) return false;
  bool any = false, holes = false;
  LineSpan upper{1.0, 0.0};  // of a piece that is cut in two
  const auto take = [&](LineSpan& piece) {
    if (gone.low >= piece.high || gone.high <= piece.low) return;
    any = true;
    if (gone.low > piece.low && gone.high < piece.high) {
      upper = {gone.high, piece.high};
      piece.high = gone.low;
    } else if (gone.low > piece.low) {
      piece.high = gone.low;
    } else {
      piece.low = std::min(gone.high, piece.high);
      holes |= piece.low >= piece.high;
    }
  };
  take(line.first);
  for (LineSpan& piece : line.above) take(piece);
  if (upper.low < upper.high)
    line.above.insert(std::upper_bound(line.above.begin(), line.above.end(), upper,
                                       [](const LineSpan& p, const LineSpan& q) { return p.low < q.low; }),
                      upper);
  if (!holes) return any;
  std::erase_if(line.above, [](const LineSpan& piece) { return piece.low >= piece.high; });
  if (line.empty() && !line.above.empty()) {
    line.first = line.above.front();
    line.above.erase(line.above.begin());
  }
  return any;
}

void StockLines::cut(std::size_t row, const PlacedSolid& solid) {
  int last = -1;
  each_line(*this, row, solid, [&](int tile, Line& one, LinePlace, LineSpan inside) {
    if (!remove(one, inside)) return;
    if (tile != last) ++rows_[row].tiles[static_cast<std::size_t>(tile)].stale, last = tile;
    if (rows_[row].tiles[static_cast<std::size_t>(tile)].stale >= kStale) bound(row, tile);
  });
}

void StockLines::bound(std::size_t row, int tile) {
  Tile found{1.0, 0.0, 0};
  for (int v = 0; v < kTile; ++v)
    for (int u = tile * kTile; u < std::min(nu_, tile * kTile + kTile); ++u) {
      const Line& one = line(row, u, v);
      if (one.empty()) continue;
      const bool none = found.low > found.high;
      found.low = none ? one.first.low : std::min(found.low, one.first.low);
      found.high = none ? one.top() : std::max(found.high, one.top());
    }
  rows_[row].tiles[static_cast<std::size_t>(tile)] = found;
}

double StockLines::deepest(std::size_t row, const PlacedSolid& solid) const {
  double most = 0.0;
  each_line(*this, row, solid, [&](int, const Line& one, LinePlace at, LineSpan inside) {
    const auto look = [&](LineSpan piece) {
      const double low = std::max(piece.low, inside.low), high = std::min(piece.high, inside.high);
      if (low >= high) return;
      // In the middle of what is met, and as near as it comes to the middle of the line's way through.
      for (const double t : {0.5 * (low + high), std::clamp(0.5 * (inside.low + inside.high), low, high)})
        most = std::max(most, solid.depth({at.u, at.v, t}, most));
    };
    look(one.first);
    for (const LineSpan& piece : one.above) look(piece);
  });
  return most;
}

bool StockLines::holds(LinePlace place) const {
  const double u = std::floor((place.u - u_) / apart_), v = std::floor((place.v - v_) / apart_);
  if (u < 0.0 || v < 0.0 || u >= nu_ || v >= nv_) return false;
  const int j = static_cast<int>(v);
  const Line& one = line(static_cast<std::size_t>(j / kTile), static_cast<int>(u), j % kTile);
  const auto in = [&](const LineSpan& piece) { return place.t >= piece.low && place.t <= piece.high; };
  return in(one.first) || std::any_of(one.above.begin(), one.above.end(), in);
}

bool StockLines::stands_about(LinePlace place) const {
  const auto first = [&](double at, double from, int count) {
    return static_cast<int>(std::clamp(std::floor((at - from) / apart_ - 0.5), -1.0, count - 1.0));
  };
  const int i = first(place.u, u_, nu_), j = first(place.v, v_, nv_);
  const double t = std::clamp(place.t, lowest_, highest_), low = t - 0.5 * apart_, high = t + 0.5 * apart_;
  const auto in = [&](const LineSpan& piece) {
    return piece.low < piece.high && piece.high >= low && piece.low <= high;
  };
  for (int v = std::max(0, j); v <= std::min(nv_ - 1, j + 1); ++v)
    for (int u = std::max(0, i); u <= std::min(nu_ - 1, i + 1); ++u) {
      const Line& one = line(static_cast<std::size_t>(v / kTile), u, v % kTile);
      if (in(one.first) || std::any_of(one.above.begin(), one.above.end(), in)) return true;
    }
  return false;
}

double StockLines::volume() const {
  double sum = 0.0;
  for (const Row& row : rows_)
    for (const Line& one : row.lines) {
      if (!one.empty()) sum += one.first.high - one.first.low;
      for (const LineSpan& piece : one.above) sum += piece.high - piece.low;
    }
  return sum * apart_ * apart_;
}

}  // namespace tiltfeed::pathgen
