#include "pathgen/flat_index.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace tiltfeed {

namespace {

/// Bins as small as keep the entries of all cells below this many a cell.
constexpr double kEntriesPerCell = 4.0;
constexpr double kMostBins = 16e6;
/// Of bins, filled side by side.
constexpr std::size_t kStripes = 2;

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double v) { low = std::min(low, v), high = std::max(high, v); }
};

/// (S1) Run interval of a cell on the line, moved by (-shift_x, -shift_y): its hull within the band of the
/// cross pad. False if the line misses it.
bool run_interval(const Cell& cell, const FlatCorner* corner, const FlatLine& line, double shift_x,
                  double shift_y, Range& run) {
  const double ax = std::abs(line.dx), ay = std::abs(line.dy);
  const double cross_pad = ay * cell.pad_x + ax * cell.pad_y;
  const double run_pad = ax * cell.pad_x + ay * cell.pad_y;
  struct Place {
    double cross, run;
  };
  Place place[8];
  std::uint32_t count = cell.count;
  const auto put = [&](std::uint32_t i, double x, double y) {
    const double px = x + shift_x - line.x, py = y + shift_y - line.y;
    place[i] = {py * line.dx - px * line.dy, px * line.dx + py * line.dy};
  };
  if (count == 2) {
    count = 4;
    put(0, corner[0].x, corner[0].y), put(1, corner[1].x, corner[0].y);
    put(2, corner[1].x, corner[1].y), put(3, corner[0].x, corner[1].y);
  } else {
    for (std::uint32_t i = 0; i < count; ++i) put(i, corner[i].x, corner[i].y);
  }
  run = {};
  std::uint32_t above = 0, below = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    above += place[i].cross > cross_pad ? 1 : 0, below += place[i].cross < -cross_pad ? 1 : 0;
    if (std::abs(place[i].cross) <= cross_pad) run.add(place[i].run);
  }
  if (above == count || below == count) return false;
  if (above + below > 0) {
    for (std::uint32_t i = 0; i < count; ++i)
      for (std::uint32_t j = i + 1; j < count; ++j)
        for (double border : {-cross_pad, cross_pad}) {
          const Place &p = place[i], &q = place[j];
          if ((p.cross < border) == (q.cross < border)) continue;
          run.add(p.run + (q.run - p.run) * ((border - p.cross) / (q.cross - p.cross)));
        }
  }
  run.low -= run_pad, run.high += run_pad;
  return run.low <= run.high;
}

/// Joins the intervals that the cells of one patch have on a line, where they overlap.
void join_pieces(std::vector<Candidate>& pieces, std::vector<Candidate>& candidates) {
  std::sort(pieces.begin(), pieces.end(), [](const Candidate& a, const Candidate& b) {
    if (a.patch != b.patch) return a.patch < b.patch;
    if (a.from != b.from) return a.from < b.from;
    return a.to < b.to;
  });
  const std::size_t first = candidates.size();
  for (const Candidate& piece : pieces) {
    if (candidates.size() > first && candidates.back().patch == piece.patch &&
        piece.from <= candidates.back().to) {
      candidates.back().to = std::max(candidates.back().to, piece.to);
      candidates.back().top = std::max(candidates.back().top, piece.top);
    } else {
      candidates.push_back(piece);
    }
  }
}

}  // namespace

bool FlatIndex::has_siblings(std::uint32_t cell) const {
  const std::vector<Cell>& cells = cells_.cells;
  return (cell > 0 && cells[cell - 1].patch == cells[cell].patch) ||
         (cell + 1 < cells.size() && cells[cell + 1].patch == cells[cell].patch);
}

std::int64_t FlatIndex::Axis::bin(double value) const {
  return static_cast<std::int64_t>(std::floor((value - low) / size));
}

std::int64_t FlatIndex::Axis::wrapped(std::int64_t b) const {
  if (period <= 0.0) return std::clamp<std::int64_t>(b, 0, count - 1);
  const std::int64_t rest = b % count;
  return rest < 0 ? rest + count : rest;
}

FlatIndex::FlatIndex(Cells cells, const Deformation& deformation) : cells_(std::move(cells)) {
  assert(!cells_.cells.empty());
  std::vector<Box> boxes(cells_.cells.size());
  tbb::parallel_for(std::size_t{0}, boxes.size(), [&](std::size_t c) { boxes[c] = box_of(cells_.cells[c]); });
  find_bounds(boxes, deformation);
  choose_bins(boxes);
  fill_bins(boxes);
}

FlatIndex::Box FlatIndex::box_of(const Cell& cell) const {
  const FlatCorner* c = cells_.corners.data() + cell.first;
  Box box{c->x, c->x, c->y, c->y};
  for (std::uint32_t i = 1; i < cell.count; ++i) {
    box.low_x = std::min<double>(box.low_x, c[i].x), box.high_x = std::max<double>(box.high_x, c[i].x);
    box.low_y = std::min<double>(box.low_y, c[i].y), box.high_y = std::max<double>(box.high_y, c[i].y);
  }
  box.low_x -= cell.pad_x, box.high_x += cell.pad_x;
  box.low_y -= cell.pad_y, box.high_y += cell.pad_y;
  return box;
}

bool FlatIndex::holds(const Cell& cell, double x, double y) const {
  const Box box = box_of(cell);
  const auto turned = [](double v, double low, double high, double period) {
    return period > 0.0 ? v + period * std::round(((low + high) / 2.0 - v) / period) : v;
  };
  const double tx = turned(x, box.low_x, box.high_x, x_.period),
               ty = turned(y, box.low_y, box.high_y, y_.period);
  return tx >= box.low_x && tx <= box.high_x && ty >= box.low_y && ty <= box.high_y;
}

double FlatIndex::crossings(double dx, double dy, double step) const {
  double widths = 0.0;
  for (const Cell& cell : cells_.cells) {
    const Box box = box_of(cell);
    widths += std::abs(dy) * (box.high_x - box.low_x) + std::abs(dx) * (box.high_y - box.low_y);
  }
  return static_cast<double>(cells_.cells.size()) + widths / step;
}

void FlatIndex::find_bounds(const std::vector<Box>& boxes, const Deformation& deformation) {
  Range x, y;
  for (const Box& box : boxes) {
    x.add(box.low_x), x.add(box.high_x), y.add(box.low_y), y.add(box.high_y);
  }
  const auto settle = [](Range& range, double period, Axis& axis) {
    if (period > 0.0 && (range.low < -period / 2.0 || range.high > period / 2.0)) {
      range.low = -period / 2.0, range.high = period / 2.0;
      axis.period = period;
    }
    axis.low = range.low;
  };
  settle(x, deformation.period_x(), x_);
  settle(y, deformation.period_y(), y_);
  if (deformation.frame().mode == AxisMode::kPoint) {  // beyond a pole lie the columns of the other side
    const double pole = kPi / 2.0 * deformation.scale_y();
    y.low = std::max(y.low, -pole), y.high = std::min(y.high, pole);
    y_.low = y.low;
  }
  bounds_ = {x.low, x.high, y.low, y.high};
}

void FlatIndex::choose_bins(const std::vector<Box>& boxes) {
  const double width = std::max(bounds_.max_x - bounds_.min_x, 1e-9);
  const double height = std::max(bounds_.max_y - bounds_.min_y, 1e-9);
  const auto count = static_cast<double>(cells_.cells.size());
  double wide = 0.0, high = 0.0, area = 0.0;
  for (const Box& box : boxes) {
    const double w = std::min(box.high_x - box.low_x, width), h = std::min(box.high_y - box.low_y, height);
    wide += w, high += h, area += w * h;
  }
  double size = std::sqrt(width * height / count);
  const auto entries = [&](double s) { return count + (wide + high) / s + area / (s * s); };
  const auto bins = [&](double s) { return std::ceil(width / s) * std::ceil(height / s); };
  while (entries(size) > kEntriesPerCell * count || bins(size) > std::min(kMostBins, 4.0 * count + 64.0))
    size *= 1.25;
  const auto divide = [size](Axis& axis, double extent) {
    axis.count = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(extent / size)));
    axis.size = extent / static_cast<double>(axis.count);
  };
  divide(x_, width);
  divide(y_, height);
}

/// Calls visit(bin) for each bin that the box overlaps, each once.
template <class Visit>
void FlatIndex::each_bin(const Box& box, Visit visit) const {
  const auto span = [](const Axis& axis, double low, double high, std::int64_t& first, std::int64_t& last) {
    first = axis.bin(low), last = axis.bin(high);
    if (axis.period > 0.0) {
      last = std::min(last, first + axis.count - 1);
    } else {
      first = axis.wrapped(first), last = axis.wrapped(last);
    }
  };
  std::int64_t i0, i1, j0, j1;
  span(x_, box.low_x, box.high_x, i0, i1);
  span(y_, box.low_y, box.high_y, j0, j1);
  for (std::int64_t j = j0; j <= j1; ++j)
    for (std::int64_t i = i0; i <= i1; ++i)
      visit(static_cast<std::size_t>(y_.wrapped(j) * x_.count + x_.wrapped(i)));
}

/// Stripes of rows are filled side by side; each bin lists its cells in rising order.
void FlatIndex::fill_bins(const std::vector<Box>& boxes) {
  const auto bins = static_cast<std::size_t>(x_.count * y_.count);
  start_.assign(bins + 1, 0);
  const auto stripe = [&](std::size_t k, const auto& visit) {
    const std::size_t low = bins * k / kStripes, high = bins * (k + 1) / kStripes;
    for (std::uint32_t c = 0; c < boxes.size(); ++c)
      each_bin(boxes[c], [&](std::size_t bin) {
        if (bin >= low && bin < high) visit(bin, c);
      });
  };
  tbb::parallel_for(std::size_t{0}, kStripes, [&](std::size_t k) {
    stripe(k, [&](std::size_t bin, std::uint32_t) { ++start_[bin + 1]; });
  });
  for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
  entries_.resize(start_.back());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  tbb::parallel_for(std::size_t{0}, kStripes, [&](std::size_t k) {
    stripe(k, [&](std::size_t bin, std::uint32_t c) { entries_[next[bin]++] = c; });
  });
}

/// A cell over the seam, or on a line that passes it, may meet the line on more than one turn.
void FlatIndex::add_cell(const Cell& cell, const FlatLine& line, const Box& swept,
                         std::vector<Candidate>& candidates) const {
  const FlatCorner* corner = cells_.corners.data() + cell.first;
  const auto add_turned = [&](double shift_x, double shift_y) {
    Range run;
    if (!run_interval(cell, corner, line, shift_x, shift_y, run)) return;
    if (run.high < 0.0 || run.low > line.length) return;
    candidates.push_back({std::max(run.low, 0.0), std::min(run.high, line.length), cell.patch, cell.top});
  };
  if (x_.period <= 0.0 && y_.period <= 0.0) return add_turned(0.0, 0.0);
  const Box box = box_of(cell);
  const auto turns = [](const Axis& axis, double low, double high, double to_low, double to_high,
                        double& first, double& last) {
    first = last = 0.0;
    if (axis.period <= 0.0) return;
    first = std::ceil((to_low - high) / axis.period), last = std::floor((to_high - low) / axis.period);
  };
  double x0, x1, y0, y1;
  turns(x_, box.low_x, box.high_x, swept.low_x, swept.high_x, x0, x1);
  turns(y_, box.low_y, box.high_y, swept.low_y, swept.high_y, y0, y1);
  for (double tx = x0; tx <= x1; ++tx)
    for (double ty = y0; ty <= y1; ++ty) add_turned(tx * x_.period, ty * y_.period);
}

void FlatIndex::along(const FlatLine& line, Scratch& scratch, std::vector<Candidate>& candidates) const {
  candidates.clear();
  scratch.pieces.clear();
  scratch.seen.resize(cells_.cells.size(), 0);
  if (++scratch.question == 0) {
    std::fill(scratch.seen.begin(), scratch.seen.end(), 0U);
    scratch.question = 1;
  }
  const double end_x = line.x_at(line.length), end_y = line.y_at(line.length);
  const Box swept{std::min(line.x, end_x), std::max(line.x, end_x), std::min(line.y, end_y),
                  std::max(line.y, end_y)};
  const auto visit = [&](std::size_t bin) {
    for (std::uint32_t e = start_[bin]; e < start_[bin + 1]; ++e) {
      const std::uint32_t c = entries_[e];
      if (scratch.seen[c] == scratch.question) continue;
      scratch.seen[c] = scratch.question;
      add_cell(cells_.cells[c], line, swept, has_siblings(c) ? scratch.pieces : candidates);
    }
  };
  if (line.dx == 0.0 || line.dy == 0.0) {
    each_bin(swept, visit);
  } else {  // piece by piece, so that a slanted line does not sweep the whole rectangle
    const double pieces = std::max(1.0, std::ceil(line.length / std::min(x_.size, y_.size)));
    for (double k = 0.0; k < pieces; ++k) {
      const double a = line.length * k / pieces, b = line.length * (k + 1.0) / pieces;
      const double xa = line.x_at(a), xb = line.x_at(b), ya = line.y_at(a), yb = line.y_at(b);
      each_bin({std::min(xa, xb), std::max(xa, xb), std::min(ya, yb), std::max(ya, yb)}, visit);
    }
  }
  join_pieces(scratch.pieces, candidates);
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    if (a.from != b.from) return a.from < b.from;
    if (a.patch != b.patch) return a.patch < b.patch;
    return a.to < b.to;
  });
}

}  // namespace tiltfeed
