#include "pathgen/pattern/level_set.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace tiltfeed::pathgen {

LevelSet::LevelSet(const LevelGrid& grid, double level, Heights& heights, double fineness)
    : grid_(grid), level_(level), fineness_(fineness), heights_(heights) {
  const std::size_t nodes = grid.node_heights.size();
  for (std::size_t n = 0; n < nodes; ++n) new_piece(higher(grid.node_heights[n]));
  const GridAxis &x = grid.x, &y = grid.y;
  row_edges_ = y.nodes() * x.cells;
  std::vector<int> on_line;
  for (int j = 0; j < y.nodes(); ++j) {
    on_line.clear();
    for (int i = 0; i <= x.cells; ++i) on_line.push_back(grid.node(i, j));
    cross_line(grid.rows[static_cast<std::size_t>(j)], {x.low, y.at(j), 1.0, 0.0, 0.0}, x.step, x.cells,
               j * x.cells, on_line);
  }
  for (int i = 0; i < x.nodes(); ++i) {
    on_line.clear();
    for (int j = 0; j <= y.cells; ++j) on_line.push_back(grid.node(i, j));
    cross_line(grid.columns[static_cast<std::size_t>(i)], {x.at(i), y.low, 0.0, 1.0, 0.0}, y.step, y.cells,
               row_edges_ + i * y.cells, on_line);
  }
  beside_.assign(crossings_.size(), {-1, -1});
  next_.assign(crossings_.size(), -1);
  cross_cells();
  close_loops();
  label_regions();
}

int LevelSet::find(int piece) const {
  auto& parent = parent_;
  while (parent[static_cast<std::size_t>(piece)] != piece) {
    int& up = parent[static_cast<std::size_t>(piece)];
    up = parent[static_cast<std::size_t>(up)];
    piece = up;
  }
  return piece;
}

/// The lower number stays, so that regions' names do not depend on the order of their pieces.
void LevelSet::unite(int a, int b) {
  a = find(a), b = find(b);
  assert(inside_[static_cast<std::size_t>(a)] == inside_[static_cast<std::size_t>(b)]);
  parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

int LevelSet::new_piece(bool inside) {
  const int piece = static_cast<int>(parent_.size());
  parent_.push_back(piece), inside_.push_back(inside);
  return piece;
}

void LevelSet::cross_line(const std::vector<HeightSample>& samples, const FlatLine& line, double step,
                          int cells, int first_edge, const std::vector<int>& nodes) {
  std::size_t next = 0;
  for (int k = 0; k < cells; ++k) {
    const int low = nodes[static_cast<std::size_t>(k)], high = nodes[static_cast<std::size_t>(k) + 1];
    const bool in_low = inside_[static_cast<std::size_t>(low)],
               in_high = inside_[static_cast<std::size_t>(high)];
    const std::vector<Crossing> found =
        cross_edge(samples, line, next, step * k, step * (k + 1), in_low, in_high);
    if (found.empty()) {
      unite(low, high);
      continue;
    }
    active_.push_back({first_edge + k, static_cast<int>(crossings_.size()), static_cast<int>(found.size()),
                       static_cast<int>(parent_.size())});
    crossings_.insert(crossings_.end(), found.begin(), found.end());
    for (std::size_t c = 1; c < found.size(); ++c) new_piece((c % 2 == 1) != in_low);
  }
}

std::vector<Crossing> LevelSet::cross_edge(const std::vector<HeightSample>& samples, const FlatLine& line,
                                           std::size_t& next, double from, double to, bool in_from,
                                           bool in_to) {
  std::vector<Crossing> found;
  double at = from;
  bool in = in_from;
  const auto step_to = [&](double run, bool higher_there) {
    if (higher_there != in) {
      Place a{line.x_at(at), line.y_at(at)}, b{line.x_at(run), line.y_at(run)};
      bisect(heights_, level_, fineness_, in ? b : a, in ? a : b);
      found.push_back(in ? Crossing{b, a} : Crossing{a, b});
    }
    at = run, in = higher_there;
  };
  while (next < samples.size() && samples[next].run <= from) ++next;
  for (; next < samples.size() && samples[next].run < to; ++next)
    step_to(samples[next].run, higher(samples[next].z));
  step_to(to, in_to);
  return found;
}

LevelSet::Side LevelSet::side_of(int edge, int low, int high) const {
  Side side;
  side.pieces.push_back(low);
  if (const int a = active_of_[static_cast<std::size_t>(edge)]; a >= 0) {
    const ActiveEdge& active = active_[static_cast<std::size_t>(a)];
    for (int c = 0; c < active.count; ++c) {
      side.crossings.push_back(active.first + c);
      side.pieces.push_back(c + 1 < active.count ? active.thin + c : high);
    }
  } else {
    side.pieces.front() = high;  // the same region
  }
  return side;
}

void LevelSet::cross_cells() {
  const GridAxis &x = grid_.x, &y = grid_.y;
  active_of_.assign(static_cast<std::size_t>(row_edges_ + x.nodes() * y.cells), -1);
  for (std::size_t a = 0; a < active_.size(); ++a)
    active_of_[static_cast<std::size_t>(active_[a].edge)] = static_cast<int>(a);
  for (int j = 0; j < y.cells; ++j)
    for (int i = 0; i < x.cells; ++i) {
      const int right = x.wraps ? (i + 1) % x.cells : i + 1, up = y.wraps ? (j + 1) % y.cells : j + 1;
      const std::array<int, 4> edges{j * x.cells + i, row_edges_ + right * y.cells + j, up * x.cells + i,
                                     row_edges_ + i * y.cells + j};
      if (std::all_of(edges.begin(), edges.end(),
                      [&](int e) { return active_of_[static_cast<std::size_t>(e)] < 0; }))
        continue;
      const int sw = grid_.node(i, j), se = grid_.node(i + 1, j), ne = grid_.node(i + 1, j + 1),
                nw = grid_.node(i, j + 1);
      resolve({x.at(i),
               y.at(j),
               x.at(i + 1),
               y.at(j + 1),
               {side_of(edges[0], sw, se), side_of(edges[1], se, ne), side_of(edges[2], nw, ne),
                side_of(edges[3], sw, nw)}},
              0);
    }
  active_of_.clear();
  active_of_.shrink_to_fit();
}

void LevelSet::close_loops() {
  std::vector<bool> done(crossings_.size(), false);
  for (std::size_t start = 0; start < crossings_.size(); ++start) {
    if (done[start]) continue;
    Loop loop;
    for (std::size_t c = start; !done[c]; c = static_cast<std::size_t>(next_[c])) {
      assert(next_[c] >= 0);
      done[c] = true;
      Crossing here = crossings_[c];
      const Place last = loop.crossings.empty() ? here.outside : loop.crossings.back().outside;
      const double dx = short_way(last.x, here.outside.x, grid_.x.period()) - here.outside.x;
      const double dy = short_way(last.y, here.outside.y, grid_.y.period()) - here.outside.y;
      here.outside = {here.outside.x + dx, here.outside.y + dy};
      here.inside = {here.inside.x + dx, here.inside.y + dy};
      loop.crossings.push_back(here);
    }
    loop.inside = beside_[start][0], loop.outside = beside_[start][1];
    loops_.push_back(std::move(loop));
  }
}

void LevelSet::label_regions() {
  std::vector<Witness> witness(parent_.size());
  const auto testify = [&](int piece, const Witness& w) {
    Witness& known = witness[static_cast<std::size_t>(find(piece))];
    if (known.node < 0 && known.edge < 0) known = w;
  };
  for (std::size_t n = 0; n < grid_.node_heights.size(); ++n)
    testify(static_cast<int>(n), {static_cast<int>(n), -1, 0.0});
  for (const ActiveEdge& e : active_)
    for (int c = 0; c + 1 < e.count; ++c) {
      const Place a = crossings_[static_cast<std::size_t>(e.first + c)].outside,
                  b = crossings_[static_cast<std::size_t>(e.first + c) + 1].outside;
      const bool row = e.edge < row_edges_;
      testify(e.thin + c, {-1, e.edge, (row ? a.x + b.x : a.y + b.y) / 2.0});
    }
  for (Loop& loop : loops_) {
    loop.inside = find(loop.inside), loop.outside = find(loop.outside);
    loop.in_inside = witness[static_cast<std::size_t>(loop.inside)];
    loop.in_outside = witness[static_cast<std::size_t>(loop.outside)];
  }
}

int LevelSet::region_at(const Witness& w) const {
  if (w.node >= 0) return find(w.node);
  if (w.edge < 0) return -1;
  const auto active = std::lower_bound(active_.begin(), active_.end(), w.edge,
                                       [](const ActiveEdge& e, int edge) { return e.edge < edge; });
  const bool row = w.edge < row_edges_;
  int before = 0, count = 0;
  if (active != active_.end() && active->edge == w.edge) {
    count = active->count;
    for (int c = 0; c < count; ++c) {
      const Place p = crossings_[static_cast<std::size_t>(active->first + c)].outside;
      before += (row ? p.x : p.y) < w.run ? 1 : 0;
    }
  }
  if (before > 0 && before < count) return find(active->thin + before - 1);
  const int line = row ? w.edge / grid_.x.cells : (w.edge - row_edges_) / grid_.y.cells;
  const int along =
      (row ? w.edge % grid_.x.cells : (w.edge - row_edges_) % grid_.y.cells) + (before > 0 ? 1 : 0);
  return find(row ? grid_.node(along, line) : grid_.node(line, along));
}

bool LevelSet::is_sea(int region) const {
  if (grid_.x.wraps && grid_.y.wraps) return false;
  return region == find(0) || region == find(static_cast<int>(grid_.node_heights.size()) - 1);
}

}  // namespace tiltfeed::pathgen
