#include "pathgen/linking/link_order.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pathgen/linking/nearest_ends.h"
#include "pathgen/linking/run_order.h"

namespace tiltfeed::pathgen {

namespace {

using Slices = std::vector<std::vector<Pass>>;

constexpr std::uint32_t kNoRun = 0xFFFFFFFF;

/// A pass as an interval on its line.
struct Run {
  std::uint32_t slice = 0, pass = 0;
  double low = 0.0, high = 0.0;
  std::uint32_t next =
      kNoRun;         ///< the one run of the next slice that it overlaps, and which overlaps no other
  bool first = true;  ///< of its region
};

/// Direction of the lines: that of the longest pass.
Vec3 line_direction(const Slices& slices) {
  Vec3 best{1, 0, 0};
  double longest = 0.0;
  for (const auto& passes : slices)
    for (const Pass& pass : passes) {
      const Vec3 d = pass.back().flat - pass.front().flat;
      const double length = std::hypot(d.x, d.y);
      if (length > longest) longest = length, best = {d.x / length, d.y / length, 0.0};
    }
  return best;
}

std::vector<Run> runs_of(const Slices& slices) {
  const Vec3 along = line_direction(slices);
  std::vector<Run> runs;
  for (std::uint32_t s = 0; s < slices.size(); ++s) {
    const auto begin = static_cast<std::ptrdiff_t>(runs.size());
    for (std::uint32_t p = 0; p < slices[s].size(); ++p) {
      const Pass& pass = slices[s][p];
      const auto run = [&](const EnvelopePoint& at) { return at.flat.x * along.x + at.flat.y * along.y; };
      const auto [low, high] = std::minmax({run(pass.front()), run(pass.back())});
      runs.push_back({s, p, low, high});
    }
    std::stable_sort(runs.begin() + begin, runs.end(),
                     [](const Run& a, const Run& b) { return a.low < b.low; });
  }
  return runs;
}

/// Links each run to the next of its region.
void find_regions(std::vector<Run>& runs) {
  std::vector<std::uint32_t> overlaps_next(runs.size()), overlaps_last(runs.size()),
      partner(runs.size(), kNoRun);
  std::size_t first = 0;
  while (first < runs.size()) {
    const auto end_of = [&](std::size_t from) {
      std::size_t to = from;
      while (to < runs.size() && runs[to].slice == runs[from].slice) ++to;
      return to;
    };
    const std::size_t next = end_of(first);
    if (next < runs.size() && runs[next].slice == runs[first].slice + 1) {
      const std::size_t end = end_of(next);
      for (std::size_t a = first, b = next; a < next && b < end;) {
        if (runs[a].low <= runs[b].high && runs[b].low <= runs[a].high) {
          ++overlaps_next[a], ++overlaps_last[b];
          partner[a] = static_cast<std::uint32_t>(b);
        }
        runs[a].high < runs[b].high ? ++a : ++b;
      }
    }
    first = next;
  }
  for (std::size_t a = 0; a < runs.size(); ++a)
    if (overlaps_next[a] == 1 && overlaps_last[partner[a]] == 1) {
      runs[a].next = partner[a];
      runs[partner[a]].first = false;
    }
}

Point<Part> lifted(const EnvelopePoint& p, const Deformation& map, double z) {
  return map.unflatten({p.flat.x, p.flat.y, z});
}

const EnvelopePoint& start_of(const Travelled& t, const Slices& slices) {
  const Pass& pass = slices[t.slice][t.pass];
  return t.reversed ? pass.back() : pass.front();
}
const EnvelopePoint& end_of(const Travelled& t, const Slices& slices) {
  const Pass& pass = slices[t.slice][t.pass];
  return t.reversed ? pass.front() : pass.back();
}

/// The ways to start a region: `downwards` from the last slice, `reversed` the first pass that is travelled.
struct Entry {
  std::uint32_t region = 0;
  bool downwards = false, reversed = false;
};

}  // namespace

Order plain_order(const Slices& slices, Direction direction) {
  Order order;
  bool reversed = false;
  for (std::uint32_t s = 0; s < slices.size(); ++s) {
    const auto count = static_cast<std::uint32_t>(slices[s].size());
    for (std::uint32_t p = 0; p < count; ++p) order.push_back({s, reversed ? count - 1 - p : p, reversed});
    if (direction == Direction::kZigzag && count > 0) reversed = !reversed;
  }
  return order;
}

namespace {

/// Of runs those of each region, by rising slice.
std::vector<std::vector<std::uint32_t>> regions_of(std::vector<Run>& runs) {
  find_regions(runs);
  std::vector<std::vector<std::uint32_t>> regions;
  for (std::uint32_t r = 0; r < runs.size(); ++r) {
    if (!runs[r].first) continue;
    regions.emplace_back();
    for (std::uint32_t at = r; at != kNoRun; at = runs[at].next) regions.back().push_back(at);
  }
  return regions;
}

}  // namespace

Order timed_order(const Slices& slices, const Deformation& deformation, const Linking& options) {
  std::vector<Run> runs = runs_of(slices);
  const auto regions = regions_of(runs);
  const bool zigzag = options.direction == Direction::kZigzag;
  // Ways up and down are the same in every order, so that those across count alone.
  const auto above = [&](const EnvelopePoint& p) {
    const AxisLine line = deformation.axis_line(p.flat.x, p.flat.y);
    return Pose{line.base + line.axis * options.clearance_z, line.axis};
  };
  // Regions fall apart where the next pass is too far off to be joined.
  std::vector<Order> travelled;
  for (const std::vector<std::uint32_t>& region : regions) {
    const Travelled* last = nullptr;
    for (const std::uint32_t run : region) {
      Travelled next{runs[run].slice, runs[run].pass, zigzag && last != nullptr && !last->reversed};
      const bool near = last != nullptr && distance(end_of(*last, slices).centre,
                                                    start_of(next, slices).centre) <= options.join_distance;
      if (!near) next.reversed = false, travelled.emplace_back();
      travelled.back().push_back(next);
      last = &travelled.back().back();
    }
  }
  if (travelled.size() < 3 || travelled.size() > kMostOrderedRuns) return {};
  std::vector<RunEnds> ends;
  for (const Order& row : travelled)
    ends.push_back({above(start_of(row.front(), slices)), above(end_of(row.back(), slices))});
  const LinkTime time({.rapid = options.rapid,
                       .up = options.up,
                       .centre = {},
                       .radius = 0.0,
                       .lift = 0.0,
                       .short_way = std::numeric_limits<double>::infinity(),
                       .short_turn = Angle::from_radians(kPi)});
  Order order;
  for (const OrderedRun& next :
       order_runs(ends, zigzag, time, ends.front().first.tip, ends.front().first.axis)) {
    Order row = travelled[next.run];
    if (next.reversed) {
      std::reverse(row.begin(), row.end());
      for (Travelled& t : row) t.reversed = !t.reversed;
    }
    order.insert(order.end(), row.begin(), row.end());
  }
  return order;
}

Order region_order(const Slices& slices, const Deformation& deformation, const Linking& options) {
  std::vector<Run> runs = runs_of(slices);
  const auto regions = regions_of(runs);
  const bool zigzag = options.direction == Direction::kZigzag;
  const auto travelled = [&](std::uint32_t run, bool reversed) {
    return Travelled{runs[run].slice, runs[run].pass, reversed};
  };
  std::vector<Entry> entries;
  std::vector<Point<Part>> places;
  std::vector<std::uint32_t> first_entry;
  for (std::uint32_t region = 0; region < regions.size(); ++region) {
    first_entry.push_back(static_cast<std::uint32_t>(entries.size()));
    for (const bool downwards : {false, true})
      for (const bool reversed : {false, true}) {
        if ((downwards || reversed) && !zigzag) continue;
        if (downwards && regions[region].size() == 1) continue;
        entries.push_back({region, downwards, reversed});
        const std::uint32_t run = downwards ? regions[region].back() : regions[region].front();
        places.push_back(
            lifted(start_of(travelled(run, reversed), slices), deformation, options.clearance_z));
      }
  }
  first_entry.push_back(static_cast<std::uint32_t>(entries.size()));

  NearestEnds ends(std::move(places));
  Order order;
  for (std::optional<std::uint32_t> at = entries.empty() ? std::nullopt : std::optional<std::uint32_t>(0);
       at;) {
    const Entry entry = entries[*at];
    for (std::uint32_t e = first_entry[entry.region]; e < first_entry[entry.region + 1]; ++e) ends.remove(e);
    std::vector<std::uint32_t> row = regions[entry.region];
    if (entry.downwards) std::reverse(row.begin(), row.end());
    bool reversed = entry.reversed;
    for (const std::uint32_t run : row) {
      order.push_back(travelled(run, reversed));
      if (zigzag) reversed = !reversed;
    }
    at = ends.nearest(lifted(end_of(order.back(), slices), deformation, options.clearance_z));
  }
  return order;
}

}  // namespace tiltfeed::pathgen
