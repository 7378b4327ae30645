#include "pathgen/slices.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kinematics/units.h"
#include "pathgen/cells.h"

namespace tiltfeed {

namespace {

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double a, double b) { low = std::min(low, a), high = std::max(high, b); }
};

/// (S1) Run interval of a cell on the slice at `level`: its hull within the band of the cross pad.
bool run_interval(const Cell& cell, const FlatCorner* corners, double level, double& from, double& to) {
  const double low = level - cell.cross_pad, high = level + cell.cross_pad;
  Range run;
  if (cell.count == 2) {
    if (corners[0].cross > high || corners[1].cross < low) return false;
    run.add(corners[0].run, corners[1].run);
  } else {
    for (std::uint32_t i = 0; i < cell.count; ++i) {
      const FlatCorner p = corners[i];
      if (p.cross >= low && p.cross <= high) run.add(p.run, p.run);
      for (std::uint32_t j = i + 1; j < cell.count; ++j)
        for (double border : {low, high}) {
          const FlatCorner q = corners[j];
          if ((p.cross < border) == (q.cross < border)) continue;
          const double at = p.run + (q.run - p.run) * ((border - p.cross) / (q.cross - p.cross));
          run.add(at, at);
        }
    }
  }
  from = run.low - cell.run_pad, to = run.high + cell.run_pad;
  return from <= to;
}

struct Entry {
  std::uint32_t slice;
  Candidate candidate;
};

/// Joins the intervals that the cells of one patch have on a slice, where they overlap: entries from `first`
/// on.
void join_intervals(std::vector<Entry>& entries, std::size_t first) {
  const auto begin = entries.begin() + static_cast<std::ptrdiff_t>(first);
  std::sort(begin, entries.end(), [](const Entry& a, const Entry& b) {
    return a.slice != b.slice ? a.slice < b.slice : a.candidate.from < b.candidate.from;
  });
  auto last = begin;
  for (auto next = begin; next != entries.end(); ++next) {
    if (next == begin) continue;
    if (next->slice == last->slice && next->candidate.from <= last->candidate.to) {
      last->candidate.to = std::max(last->candidate.to, next->candidate.to);
    } else {
      *++last = *next;
    }
  }
  if (begin != entries.end()) entries.erase(last + 1, entries.end());
}

/// The candidates of one block of cells on every slice; a cell over the seam comes once on each side of it.
std::vector<Entry> entries_of(const CellBlock& block, const Slices& s, double cross_period,
                              double run_period) {
  std::vector<Entry> entries;
  const auto count = static_cast<double>(s.start.size() - 1);
  const auto add = [&](std::uint32_t k, double from, double to, PatchId patch) {
    if (to < s.run_min || from > s.run_max) return;
    entries.push_back({k, {std::max(from, s.run_min), std::min(to, s.run_max), patch}});
  };
  std::size_t first = 0;  // entry of the patch under way
  for (std::size_t c = 0; c < block.cells.size(); ++c) {
    const Cell& cell = block.cells[c];
    if (c > 0 && block.cells[c - 1].patch != cell.patch) {
      if (c > 1 && block.cells[c - 2].patch == block.cells[c - 1].patch) join_intervals(entries, first);
      first = entries.size();
    }
    const FlatCorner* corners = block.corners.data() + cell.first;
    Range cross;
    for (std::uint32_t i = 0; i < cell.count; ++i) cross.add(corners[i].cross, corners[i].cross);
    const int turns = cross_period > 0.0 ? 1 : 0;
    for (int turn = -turns; turn <= turns; ++turn) {
      const double shift = turn * cross_period;
      const double low = std::ceil((cross.low - cell.cross_pad + shift - s.first) / s.step);
      const double high = std::floor((cross.high + cell.cross_pad + shift - s.first) / s.step);
      for (double k = std::max(0.0, low); k <= std::min(count - 1.0, high); ++k) {
        double from, to;
        if (!run_interval(cell, corners, s.first + k * s.step - shift, from, to)) continue;
        const auto index = static_cast<std::uint32_t>(k);
        add(index, from, to, cell.patch);
        if (run_period > 0.0) {
          add(index, from + run_period, to + run_period, cell.patch);
          add(index, from - run_period, to - run_period, cell.patch);
        }
      }
    }
  }
  join_intervals(entries, first);
  return entries;
}

Range full_turn(double period) {
  Range range;
  range.add(-period / 2.0, period / 2.0);
  return range;
}

/// Even levels over `cross`, half a step inside its ends (all round: half a step past the seam).
bool lay_levels(const Range& cross, double side_step, Slices& s) {
  const double count = std::max(1.0, std::ceil((cross.high - cross.low) / side_step - 1e-9));
  if (count > static_cast<double>(kMaxSlices)) return false;
  s.step = (cross.high - cross.low) / count;
  s.first = cross.low + s.step / 2.0;
  if (s.step <= 0.0) s.step = side_step, s.first = cross.low;
  s.start.assign(static_cast<std::size_t>(count) + 1, 0);
  return true;
}

void fill(const std::vector<CellBlock>& blocks, double cross_period, double run_period, Slices& s) {
  std::vector<std::vector<Entry>> entries(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(),
                    [&](std::size_t b) { entries[b] = entries_of(blocks[b], s, cross_period, run_period); });
  for (const auto& list : entries)
    for (const Entry& e : list) ++s.start[e.slice + 1];
  for (std::size_t k = 0; k + 1 < s.start.size(); ++k) s.start[k + 1] += s.start[k];
  s.candidates.resize(s.start.back());
  std::vector<std::size_t> next(s.start.begin(), s.start.end() - 1);
  for (auto& list : entries) {
    for (const Entry& e : list) s.candidates[next[e.slice]++] = e.candidate;
    std::vector<Entry>().swap(list);
  }
  tbb::parallel_for(std::size_t{0}, s.count(), [&](std::size_t k) {
    std::sort(s.candidates.begin() + static_cast<std::ptrdiff_t>(s.start[k]),
              s.candidates.begin() + static_cast<std::ptrdiff_t>(s.start[k + 1]),
              [](const Candidate& a, const Candidate& b) {
                if (a.from != b.from) return a.from < b.from;
                if (a.patch != b.patch) return a.patch < b.patch;
                return a.to < b.to;
              });
  });
}

}  // namespace

Result<Slices> slice(const ClSurface& surface, const Deformation& map, Along along, double side_step) {
  const std::vector<CellBlock> blocks = make_cells(surface, map, along, side_step);
  Range cross, run;
  double widths = 0.0;
  std::size_t cells = 0;
  Slices s;
  for (const CellBlock& block : blocks) {
    cells += block.cells.size();
    s.near.insert(s.near.end(), block.near.begin(), block.near.end());
    for (const Cell& cell : block.cells) {
      Range own;
      for (std::uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
        own.add(block.corners[i].cross - cell.cross_pad, block.corners[i].cross + cell.cross_pad);
        run.add(block.corners[i].run - cell.run_pad, block.corners[i].run + cell.run_pad);
      }
      cross.add(own.low, own.high);
      widths += own.high - own.low;
    }
  }
  if (!(cross.low <= cross.high))
    return fail(Code::kUnreachable,
                "no facet of the part faces the tool: check axis.sense, axis.origin_mm and axis.n");
  const double cross_period = along == Along::kX ? map.period_y() : map.period_x();
  const double run_period = along == Along::kX ? map.period_x() : map.period_y();
  const auto wraps = [](const Range& range, double period) {
    return period > 0.0 && (range.low < -period / 2.0 || range.high > period / 2.0);
  };
  if (wraps(cross, cross_period)) cross = full_turn(cross_period);
  if (wraps(run, run_period)) run = full_turn(run_period);
  if (map.frame().mode == AxisMode::kPoint) {  // beyond a pole lie the columns of the other side again
    Range& phi = along == Along::kX ? cross : run;
    const double pole = kPi / 2.0 * map.scale_y();
    phi.low = std::max(phi.low, -pole), phi.high = std::min(phi.high, pole);
  }
  s.along = along;
  s.run_min = run.low, s.run_max = run.high;
  if (!lay_levels(cross, side_step, s))
    return fail(Code::kLimit, "pattern.side_step_mm of " + std::to_string(side_step) +
                                  " asks for more than " + std::to_string(kMaxSlices) + " passes over " +
                                  std::to_string(cross.high - cross.low) + " mm; use a larger step");
  if (const double asked = static_cast<double>(cells) + widths / s.step; asked > kMaxCandidates)
    return fail(
        Code::kLimit,
        "pattern.side_step_mm of " + std::to_string(side_step) + " cuts the part's facets " +
            std::to_string(static_cast<long long>(asked / 1e6)) +
            " million times, more than memory is set aside for; use a larger step, or a coarser mesh");
  fill(blocks, cross_period, run_period, s);
  return s;
}

}  // namespace tiltfeed
